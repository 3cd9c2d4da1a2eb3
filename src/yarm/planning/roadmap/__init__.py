"""Particles, the graph over them, and the search on it."""
