"""Map files: map_server's image and yaml, and plain pictures."""
