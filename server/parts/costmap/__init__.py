"""Costs over the map of a session, see :mod:`mapper.costmap`."""
