"""Readers of logs that are text, one file per format, and what they share."""
