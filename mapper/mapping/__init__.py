"""Mapping with known poses: inverse sensor models, updates, provenance, and their textbook statement."""
