"""Overhead cameras' poses: the camera_watch node and the command calibrate_cameras."""
