"""The HTTP and WebSocket routes. They only parse, call and answer."""
