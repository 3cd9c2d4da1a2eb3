"""Motion of one robot: omnidirectional base, sander raster, arm kinematics."""
