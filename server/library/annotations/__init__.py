"""What visitors add to logs: notes, tags, links, trajectories, puzzles."""
