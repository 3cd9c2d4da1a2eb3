"""Turns in place, about the end effector, that mobile robots are told to make, deg; positive to the left."""

QUARTER_TURNS_DEG = (0.0, 90.0, -90.0)
"""Those of the published system; a robot keeps to the headings that they lead to from the one it started with."""
FINER_TURNS_DEG = (45.0, -45.0)
"""Those it makes too where quarter turns leave no way."""
