"""Image tags on boxes: their pictures, features, and recognition; no ROS."""
