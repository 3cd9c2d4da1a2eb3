# The ROS-free perception library, and the nodelets and nodes on top of it.
