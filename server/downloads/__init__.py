"""Downloads: bounded in number and memory, streamed, and stopped if the client disconnects."""

from server.downloads.compressed_image import CompressedImage
from server.downloads.download_slots import BusyError, DownloadSlots
from server.downloads.downloads import Content, Downloads
from server.downloads.map_snapshots import MapSnapshot, MapSnapshotGoneError, MapSnapshots
from server.downloads.names import SNAPSHOT_NAME, file_name, file_stem
from server.downloads.response import Download

__all__ = [
    "SNAPSHOT_NAME",
    "BusyError",
    "CompressedImage",
    "Content",
    "Download",
    "DownloadSlots",
    "Downloads",
    "MapSnapshot",
    "MapSnapshotGoneError",
    "MapSnapshots",
    "file_name",
    "file_stem",
]
