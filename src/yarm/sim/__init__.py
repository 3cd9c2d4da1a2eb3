"""The simulated cell: PyBullet world, depth cameras, scenes."""
