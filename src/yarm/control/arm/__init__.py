"""The manipulator: model, collisions, motion, planning."""
