"""Decoders of ROS's messages, and of Foxglove's, which become messages of ROS."""
