"""The cell_registry node."""
