"""Nodes of one robot in a room."""
