"""Compiled functions of terrain: bare arrays, results written into ``out``, no errors."""
