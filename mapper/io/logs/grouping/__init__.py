"""Scans of one sensor in groups with equal beams and limits, for all log formats."""
