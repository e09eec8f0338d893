"""What is read of an upload, as the files that the library keeps of it."""
