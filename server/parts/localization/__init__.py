"""Localization of a session's robot in a reference map, see :mod:`mapper.localization`."""
