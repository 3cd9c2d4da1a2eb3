"""The youBot's arm and ROS: checkpoints out of bags, motions into messages."""
