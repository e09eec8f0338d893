"""Readers of text logs, one module per format, and shared code."""
