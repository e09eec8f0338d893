"""Uploaded logs: what is stored, what is known of it, and the jobs that read it."""

from server.library.intake import Part
from server.library.library import Library, LibraryLimits, LogNotFoundError, LogReadOnlyError
from server.library.records import Record
from server.library.sample import SAMPLE_ID

__all__ = [
    "SAMPLE_ID",
    "Library",
    "LibraryLimits",
    "LogNotFoundError",
    "LogReadOnlyError",
    "Part",
    "Record",
]
