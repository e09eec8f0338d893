"""Range scans and logs of scans as arrays."""
