"""The seed_tf_publisher node."""
