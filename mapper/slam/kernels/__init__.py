"""Compiled functions of the pose graph."""
