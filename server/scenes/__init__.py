"""The 3D view: one loopback-only viser server for each session that asks, behind a proxy."""
