"""Compiled functions over grid cells. They import only NumPy, numba and :mod:`mapper.core`."""
