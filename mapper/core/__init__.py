"""Shared utilities of the mapper: errors, limits, SE(2), parallel ranges, compiled kernels, atomic files."""
