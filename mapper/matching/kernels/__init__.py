"""Compiled kernels of scan matching."""
