"""The tile stream: the wire format, what changed, and who still needs it."""
