"""Data read from uploads, as the files that the library stores."""
