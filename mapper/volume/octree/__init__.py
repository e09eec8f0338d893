"""The octree of a map and OctoMap's files."""
