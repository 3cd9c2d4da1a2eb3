"""Independent checks: they share no code with the planners."""
