"""Nodes of the exploration: the explorer and the velocity gate behind it."""
