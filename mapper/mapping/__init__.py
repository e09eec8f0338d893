"""Mapping with known poses: inverse sensor models, updates, provenance, and the same algorithms in plain Python."""
