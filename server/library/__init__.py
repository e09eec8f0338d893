"""Uploaded logs: what is stored, what is known of it, and the jobs that read it."""

from server.library.added import TrajectoryNotFoundError
from server.library.library import Library
from server.library.limits import LibraryLimits
from server.library.link import Link, LinkGoneError
from server.library.log_errors import LogNotFoundError, LogReadOnlyError
from server.library.records import Record
from server.library.sample import SAMPLE_ID
from server.library.storage import StorageError, claimed
from server.library.store_check import check_stores
from server.library.upload_receiver import Part

__all__ = [
    "SAMPLE_ID",
    "Library",
    "LibraryLimits",
    "Link",
    "LinkGoneError",
    "LogNotFoundError",
    "LogReadOnlyError",
    "Part",
    "Record",
    "StorageError",
    "TrajectoryNotFoundError",
    "check_stores",
    "claimed",
]
