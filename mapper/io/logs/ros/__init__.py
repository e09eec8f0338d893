"""Decoders of ROS messages, and of Foxglove messages, which are converted to ROS messages."""
