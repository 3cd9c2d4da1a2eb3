"""Finding and following a way over a flat occupancy map; shared by exploration and inspection."""
