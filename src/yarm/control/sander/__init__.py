"""The HC10 sander: scan, raster, state machine."""
