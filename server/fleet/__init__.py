"""Many logs read, examined and mapped, on this machine or on a Dask cluster."""

from server.fleet.job import FleetJob, FleetLimits
from server.fleet.run import Fleet, Result, workers_at

__all__ = ["Fleet", "FleetJob", "FleetLimits", "Result", "workers_at"]
