"""Contents of a recording other than the scans for a map: topics, transforms over time, and series for plots."""
