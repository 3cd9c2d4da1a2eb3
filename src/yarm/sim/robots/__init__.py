"""Robots in the physics world."""
