"""The scans that a map is made of: from files, in memory, and a map after each."""
