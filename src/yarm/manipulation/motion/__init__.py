"""Motions in time, checkpoints, and the tour that joins them."""
