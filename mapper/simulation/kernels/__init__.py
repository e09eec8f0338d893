"""Compiled ray casts and shortest paths of the simulator."""
