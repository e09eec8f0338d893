"""The records of logs, and the logs that are not uploads."""
