"""The path to a goal on the costmap of a session, see :mod:`mapper.planning`."""
