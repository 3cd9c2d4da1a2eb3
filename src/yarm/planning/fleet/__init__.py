"""Planning for several robots at once: YARM."""
