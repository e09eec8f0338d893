"""The library's storage: the database and the blobs."""
