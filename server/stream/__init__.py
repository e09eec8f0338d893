"""The stream: the wire format, the layers, and what was sent to each client."""
