"""Editing of a map, see :mod:`mapper.editing`."""
