"""Where cameras are, from what they see of things whose place is known."""
