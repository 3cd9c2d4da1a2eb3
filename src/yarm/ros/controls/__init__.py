"""The multi_robot_controls_server node."""
