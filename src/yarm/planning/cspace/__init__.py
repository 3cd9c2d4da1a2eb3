"""Columns of cells as bits, shapes of robots, and where a robot may stand and move."""
