"""Where and when work is computed."""
