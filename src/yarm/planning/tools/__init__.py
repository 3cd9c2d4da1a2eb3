"""The command line and the pictures."""
