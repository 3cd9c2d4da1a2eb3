"""What is asked of a planner and what it answers; its parameters."""
