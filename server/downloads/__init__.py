"""Files that are made for a visitor and sent: bounded in number and memory, streamed, ended with their client."""

from server.downloads.downloads import Content, Downloads
from server.downloads.moments import Moment, MomentGoneError, Moments
from server.downloads.names import MOMENT_NAME, file_name, file_stem
from server.downloads.places import BusyError, Places
from server.downloads.response import Download
from server.downloads.snapshot import Snapshot

__all__ = [
    "MOMENT_NAME",
    "BusyError",
    "Content",
    "Download",
    "Downloads",
    "Moment",
    "MomentGoneError",
    "Moments",
    "Places",
    "Snapshot",
    "file_name",
    "file_stem",
]
