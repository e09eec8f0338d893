"""Access to the bytes of a log file, in an archive or not, compressed or plain, in pieces and with limits."""
