"""What a recording holds besides the scans of its map: every topic, transforms over time, and series for plots."""
