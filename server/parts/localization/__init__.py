"""Where the robot of a session is in a reference map, see :mod:`mapper.localization`."""
