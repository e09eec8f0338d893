"""The 3D map of a session, see :mod:`mapper.volume`."""
