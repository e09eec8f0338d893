"""Log-odds of occupancy in blocks of voxels, and what is asked of such a map."""
