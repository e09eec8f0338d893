"""Maps of a log, and what is done with map files."""
