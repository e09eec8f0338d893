"""A data folder of version 0.1.0, which kept records as files of JSON and blobs by the logs' ids, loses nothing.

The records are those that its code wrote, with another time.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mapper.io.logs import open_robot_log
from server.library import Library
from server.library.log_pack import write_pack
from server.settings import Settings
from tests.server.library.small_logs import carmen
from tests.server.service import eventually

pytestmark = pytest.mark.asyncio(loop_scope="module")
SUMMARY = json.loads(
    """{"name": "5287074dd63c767c98b2", "format": "CARMEN FLASER", "scans": 5, "beams": 3, "duration_s": 4.0,
    "field_of_view_deg": 180.0, "angle_min": -1.5707963267948966, "angle_increment": 1.5707963267948966,
    "range_max": 80.0, "mount": [0.0, 0.0, 0.0], "readings": {"measured": 15, "no_return": 0, "invalid": 0},
    "trajectories": [{"name": "scan", "description": "the pose in each FLASER line", "length_m": 4.0}], "notes": [],
    "upside_down": false, "time": {"start_s": null, "rate_hz": 1.0, "gaps": 0, "longest_gap_s": 0.0,
    "longest_gap_at_s": 0.0}, "topics": [{"name": "FLASER", "type": "laser scan", "count": 5, "frame": null, "beams": 3,
    "field_of_view_deg": 180.0, "rate_hz": 1.0, "mount": [0.0, 0.0, 0.0], "chosen": true}]}"""
)


def keep(root: Path, log_id: str, owner: str, data: bytes, **more: Any) -> None:
    """Files that version 0.1.0 kept of an upload."""
    for folder in ("blobs", "packs", "records", "incoming"):
        (root / folder).mkdir(parents=True, exist_ok=True)
    record: dict[str, Any] = {"id": log_id, "owner": owner, "name": "run.log", "source": "upload", "state": "ready"}
    record |= {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    record |= {"created_s": time.time() - 9.0, "used_s": time.time() - 9.0, "progress": 1.0, "error": None}
    record |= {"summary": SUMMARY} | more
    (root / "blobs" / log_id).write_bytes(data)
    (root / "records" / f"{log_id}.json").write_text(json.dumps(record, ensure_ascii=False, indent=1))
    if record["state"] == "ready":
        write_pack(open_robot_log(root / "blobs" / log_id), root / "packs" / f"{log_id}.npz")


async def test_an_older_data_folder_is_taken_over(make_library: Callable[..., Library], settings: Settings) -> None:
    root = settings.data_dir / "library"
    keep(root, "5287074dd63c767c98b2", "ann", carmen(5), name="Café run.log")
    keep(root, "df29cc71afc3d9b5849b", "bob", carmen(5))
    error = {"code": "log.unknown_format", "message": "The file is no log of a known kind."}
    keep(root, "295e4bca33e10b93cd42", "ann", b"Dear all,\n", state="failed", progress=0.0, error=error, summary=None)
    keep(root, "c602db6a40ebabcde6c6", "ann", carmen(9), state="queued", progress=0.0, summary=None)
    keep(root, "folder-d8d1bf42d88745e9d8e5", "", b"", source="folder", sha256="", state="reading")  # gone since
    (root / "records" / "garbage.json").write_text("{")
    (root / "records" / "no-bytes.json").write_text(
        (root / "records" / "5287074dd63c767c98b2.json").read_text().replace("5287074dd63c767c98b2", "no-bytes")
    )
    # A start that was cut after the first blob had moved.
    (root / "blobs" / "df29cc71afc3d9b5849b").replace(root / "blobs" / hashlib.sha256(carmen(5)).hexdigest())

    library = make_library(own_reader=True)
    await library.start()
    own = {record.name: record for record in await library.list("ann") if record.source == "upload"}
    assert set(own) == {"Café run.log", "run.log"}
    ready = library.get("ann", "5287074dd63c767c98b2")
    assert (ready.state, ready.progress, ready.public()["scans"]) == ("ready", 1.0, 5)
    assert (await library.load("ann", ready.id)).n_scans == 5
    assert (await library.load("bob", "df29cc71afc3d9b5849b")).n_scans == 5
    failed = library.get("ann", "295e4bca33e10b93cd42")
    assert failed.error is not None
    assert failed.error.code == "log.unknown_format"
    # Its reading was interrupted: it is read now.
    await eventually(lambda: library.get("ann", "c602db6a40ebabcde6c6").state == "ready")
    assert sorted(path.name for path in (root / "blobs").iterdir()) == sorted(
        hashlib.sha256(data).hexdigest() for data in (carmen(5), b"Dear all,\n", carmen(9))
    )
    # What is no record, and the record whose bytes are nowhere … here they are: another's were the same.
    assert [path.name for path in (root / "records").iterdir()] == ["garbage.json"]
    await library.close()

    again = make_library()
    await again.start()
    assert (await again.load("ann", ready.id)).n_scans == 5
