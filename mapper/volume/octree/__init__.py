"""Octree of a map, and OctoMap's files."""
