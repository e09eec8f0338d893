"""Compiled functions of volumes: bare arrays, results written into ``out``, no errors."""
