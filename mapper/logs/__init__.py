"""Readers of robot logs, one per format, behind one ``open_log``."""
