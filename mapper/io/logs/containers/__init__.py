"""Readers of the files that recordings are kept in: ROS 1 bags, SQLite bags of ROS 2, MCAP."""
