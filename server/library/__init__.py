"""Uploaded logs: what is stored, what is known of it, and the jobs that read it."""

from server.library.library import (
    SAMPLE_ID,
    Library,
    LibraryLimits,
    LogNotFoundError,
    LogReadOnlyError,
)
from server.library.records import Record

__all__ = [
    "SAMPLE_ID",
    "Library",
    "LibraryLimits",
    "LogNotFoundError",
    "LogReadOnlyError",
    "Record",
]
