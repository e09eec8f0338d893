"""Compiled functions of costmaps: bare arrays, results written into ``out``, no errors."""
