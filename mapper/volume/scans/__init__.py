"""Scans from which maps are built: from files, in memory, and replayed maps."""
