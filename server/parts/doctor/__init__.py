"""The diagnosis of a log, see :mod:`mapper.diagnosis`."""
