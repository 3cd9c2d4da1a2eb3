"""The safety_monitor node."""
