"""The notes on a log, see :mod:`server.library.annotations.notes`."""
