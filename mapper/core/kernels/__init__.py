"""Compiled kernels that belong to no field of their own."""
