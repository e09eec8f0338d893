"""Uploads while they arrive."""
