"""Depth cameras and their rays."""
