"""HTTP: routes, security and the shape of errors."""
