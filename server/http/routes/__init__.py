"""The HTTP and WebSocket routes: thin; parse, call, answer."""
