"""Terrain of points: where it is safe to drive, see :mod:`mapper.terrain`."""
