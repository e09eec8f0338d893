"""Uploaded logs: what is stored, what is known of it, and the jobs that read it."""
