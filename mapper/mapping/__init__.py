"""Mapping with known poses: inverse sensor models, updates, provenance, and textbook versions in plain Python."""
