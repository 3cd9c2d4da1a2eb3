"""The commander node and its command line."""
