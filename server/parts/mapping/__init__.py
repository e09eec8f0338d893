"""The parameters of the map of a session, see :mod:`mapper.mapping`."""
