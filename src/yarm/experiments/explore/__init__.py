"""Explorations without ROS: a controller in the kinematic world, the truth about the arena, what was measured."""
