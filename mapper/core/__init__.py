"""What every part of the mapper uses: errors, limits, SE(2), parallel ranges, compiled kernels, atomic files."""
