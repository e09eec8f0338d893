"""Readers of recording containers: ROS 1 bags, SQLite bags of ROS 2, MCAP."""
