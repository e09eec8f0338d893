"""Maps of a log, and operations on map files."""
