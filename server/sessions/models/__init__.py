"""The models of sessions: one file for each kind, and their helpers."""
