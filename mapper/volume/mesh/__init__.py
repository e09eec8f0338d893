"""Triangles of surfaces and faces of voxels, in chunks, and mesh files."""
