"""Whether a scene can be done."""
