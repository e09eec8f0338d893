"""Downloads: bounded in number and memory, streamed, and stopped if the client disconnects."""

from server.downloads.download_slots import BusyError, DownloadSlots
from server.downloads.downloads import Content, Downloads
from server.downloads.map_snapshots import MapSnapshot, MapSnapshotGoneError, MapSnapshots
from server.downloads.names import SNAPSHOT_NAME, file_name, file_stem
from server.downloads.response import Download
from server.downloads.snapshot import Snapshot

__all__ = [
    "SNAPSHOT_NAME",
    "BusyError",
    "Content",
    "Download",
    "DownloadSlots",
    "Downloads",
    "MapSnapshot",
    "MapSnapshotGoneError",
    "MapSnapshots",
    "Snapshot",
    "file_name",
    "file_stem",
]
