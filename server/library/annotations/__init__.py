"""Additions of visitors to logs: notes, tags, links, trajectories, puzzles."""
