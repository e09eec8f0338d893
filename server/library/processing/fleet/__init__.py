"""Mapping all logs of a library, on this machine or on a Dask cluster."""
