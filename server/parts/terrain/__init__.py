"""Terrain of points: where driving is safe, see :mod:`mapper.terrain`."""
