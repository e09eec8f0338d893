"""Scan matching: the pose at which two scans, a scan and a map, or two maps lie on one another."""
