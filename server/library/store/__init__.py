"""Where the library keeps what it has: the database and the blobs."""
