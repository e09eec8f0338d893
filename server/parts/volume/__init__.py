"""The map in 3D of a session, see :mod:`mapper.volume`."""
