"""Compiled functions of planning: bare arrays, results written into ``out``, no errors."""
