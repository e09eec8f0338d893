"""Where the robot of a session is in a given map, see :mod:`mapper.localization`."""
