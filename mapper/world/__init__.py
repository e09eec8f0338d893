"""The simulator: worlds, lidar, and a robot that walks by itself."""
