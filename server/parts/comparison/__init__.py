"""A second map of the same session."""
