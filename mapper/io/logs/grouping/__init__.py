"""The scans of one sensor in groups that have the same beams and limits, whatever the format of their log."""
