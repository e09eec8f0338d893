"""Uploaded logs: their storage, their records, and the jobs that read them."""
