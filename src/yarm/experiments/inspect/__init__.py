"""Inspection rounds without ROS: drives in the kinematic world, drawn pictures read by the recognition, the truth."""
