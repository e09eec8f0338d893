"""Jobs: processes with limits, workers that run jobs in them, one queue and record, leases among services."""
