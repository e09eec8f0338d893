"""Log-odds of occupancy in blocks of voxels, and queries of such maps."""
