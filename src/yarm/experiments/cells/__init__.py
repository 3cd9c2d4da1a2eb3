"""Missions in random cells: what each must come to, and how often it does not."""
