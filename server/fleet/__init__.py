"""Reads, examines and maps many log files into a folder, on this machine or on a Dask cluster."""

from server.fleet.run import Fleet, Result, workers_at
from server.library.processing.fleet.fleet_job import FleetJob

__all__ = ["Fleet", "FleetJob", "Result", "workers_at"]
