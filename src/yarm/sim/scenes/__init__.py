"""Scenes and their events, from YAML."""
