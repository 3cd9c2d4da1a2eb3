"""Who goes for what."""
