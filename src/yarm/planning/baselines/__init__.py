"""Other planners behind the same interface."""
