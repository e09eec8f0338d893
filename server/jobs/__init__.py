"""Jobs: processes with limits, workers that have them, leases among services."""
