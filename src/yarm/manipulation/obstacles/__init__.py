"""The arm among obstacles: what it may not touch, fields, planned ways, and the proof in physics."""
