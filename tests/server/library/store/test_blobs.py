"""A store of blobs keeps each file completely or not at all: in a folder, and in a remote store."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest
from obstore.store import MemoryStore

from server.library.store.blobs import REMOTE_PART_BYTES, Blobs
from server.storage import StorageError

DATA = bytes(range(256)) * 4000
NAME = hashlib.sha256(DATA).hexdigest()


@pytest.fixture(params=["folder", "memory"])
def blobs(request: pytest.FixtureRequest, tmp_path: Path) -> Blobs:
    local = Blobs.at(None, tmp_path)
    return local if request.param == "folder" else Blobs(MemoryStore(), None, tmp_path / "incoming")


def left(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


async def put(blobs: Blobs, data: bytes, piece: int = 100_000) -> str:
    incoming = blobs.incoming()
    for start in range(0, len(data), piece):
        await incoming.write(data[start : start + piece])
    assert incoming.size == len(data)
    await incoming.commit()
    await incoming.discard()  # too late to change anything
    return incoming.sha256


@pytest.mark.parametrize("piece", [7_777, 300_000, len(DATA)])
async def test_blobs_are_read_back_by_their_digest(blobs: Blobs, tmp_path: Path, piece: int) -> None:
    assert await put(blobs, DATA, piece) == NAME
    assert await put(blobs, DATA) == NAME
    other = await put(blobs, b"other")
    assert await blobs.names() == {NAME, other}
    async with blobs.file(NAME) as path:
        assert path.read_bytes() == DATA
    assert [name for name in left(tmp_path) if not name.startswith("blobs/")] == [], "no copy is left"
    await blobs.delete(NAME)
    await blobs.delete(NAME)
    assert await blobs.names() == {other}


async def test_in_a_folder_a_blob_is_read_without_a_copy(tmp_path: Path) -> None:
    blobs = Blobs.at(str(tmp_path / "elsewhere"), tmp_path / "data")
    (tmp_path / "data" / "incoming").mkdir(parents=True)
    await put(blobs, DATA)
    async with blobs.file(NAME) as path:
        assert path == tmp_path / "elsewhere" / "blobs" / NAME
    assert path.exists()
    assert path.parent.stat().st_mode & 0o077 == 0, "no other account of the machine looks into it"


@pytest.mark.parametrize("size", [10, 3 * REMOTE_PART_BYTES])
async def test_a_discarded_upload_leaves_no_file(blobs: Blobs, tmp_path: Path, size: int) -> None:
    incoming = blobs.incoming()
    await incoming.write(bytes(size))
    await incoming.discard()
    await incoming.write(b"late")
    await incoming.discard()
    await blobs.remove_unreferenced([])
    assert await blobs.names() == set()
    assert left(tmp_path) == []


async def test_remove_unreferenced_keeps_the_named_blobs(blobs: Blobs, tmp_path: Path) -> None:
    await put(blobs, DATA)
    await put(blobs, b"nobody's")
    half = blobs.incoming()
    await half.write(DATA)
    (tmp_path / "incoming" / "half#1").write_bytes(b"of a killed process")
    (tmp_path / "incoming" / "half.reading").mkdir()
    (tmp_path / "incoming" / "half.reading" / "a.png").write_bytes(b"that it unpacked")
    await blobs.remove_unreferenced({NAME, "not there"})
    assert await blobs.names() == {NAME}
    assert not left(tmp_path / "incoming")


async def test_a_local_file_is_moved_into_the_store(blobs: Blobs, tmp_path: Path) -> None:
    (tmp_path / "old").write_bytes(DATA)
    await blobs.move_in(tmp_path / "old", NAME)
    assert not (tmp_path / "old").exists()
    async with blobs.file(NAME) as path:
        assert path.read_bytes() == DATA


async def test_an_unreachable_bucket_gives_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.library.store.blobs.RETRY", {"max_retries": 0})
    monkeypatch.setenv("AWS_ENDPOINT", "http://127.0.0.1:1")
    for name in ("AWS_ALLOW_HTTP", "AWS_SKIP_SIGNATURE"):
        monkeypatch.setenv(name, "true")
    blobs = Blobs.at("s3://a-bucket/logs", tmp_path)
    incoming = blobs.incoming()
    await incoming.write(b"a log")
    for refused in (incoming.commit(), blobs.names()):
        with pytest.raises(StorageError) as caught:
            await refused
        assert (caught.value.code, caught.value.message[-1]) == ("log.store", ".")
    await incoming.discard()


async def test_an_error_of_a_store_gives_one_sentence(tmp_path: Path) -> None:
    memory = Blobs(MemoryStore(), None, tmp_path)
    with pytest.raises(StorageError) as caught:
        async with memory.file(NAME):
            pass
    assert caught.value.code == "log.gone"
    local = Blobs.at(None, tmp_path)
    incoming = local.incoming()
    await incoming.write(DATA)
    (tmp_path / "blobs").rmdir()
    (tmp_path / "blobs").write_bytes(b"a file where the folder was")
    with pytest.raises(StorageError) as caught:
        await incoming.commit()
    assert caught.value.code == "log.storage"
    assert str(tmp_path) not in caught.value.message
    assert left(tmp_path / "incoming") == []
