"""The facts of each robot."""
