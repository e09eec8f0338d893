"""Compiled kernels that belong to no particular field."""
