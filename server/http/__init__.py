"""HTTP: routes, security and the form of errors."""
