"""Contents of a recording besides the scans of its map: topics, transforms over time, and series for plots."""
