"""Files of kilobytes that expand to 4 GiB: each is refused in bounded memory and time."""

from __future__ import annotations

import gzip
import json
import lzma
import struct
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import lz4.frame
import pytest
import zstandard

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS
from tests.hostile import bombs
from tests.hostile.corpus import TEXTS, bag_record, bag_with_chunk, mcap_with_chunk
from tests.hostile.damage import ALL, opened

ROOT = Path(__file__).parents[2]
SIZE = 4 * bombs.GIB
BAG, MCAP, SQLITE = b"#ROSBAG V2.0\n", b"\x89MCAP0\r\n", b"SQLite format 3\0"
#: A record of each that claims all that follows, of a kind that is skipped.
BAG_SKIPPED = BAG + bag_record({"op": b"\x09"}, b"")[:-4] + b"\xff\xff\xff\xff"
MCAP_SKIPPED = MCAP + struct.pack("<BQ", 0x7F, 1 << 40)

#: What is packed in which way → the file, and the code of its refusal.
CASES: dict[str, tuple[Callable[[], bytes], str]] = {
    "a bag's bz2 chunk": (lambda: bag_with_chunk("bz2", bombs.of_zeros("bz2", SIZE)), "log.too_many_bytes"),
    "a bag's lz4 chunk": (lambda: bag_with_chunk("lz4", bombs.of_zeros("lz4", SIZE)), "log.too_many_bytes"),
    "an mcap's lz4 chunk": (lambda: mcap_with_chunk("lz4", bombs.of_zeros("lz4", SIZE), 100), "log.too_many_bytes"),
    "an mcap's zstd chunk": (lambda: mcap_with_chunk("zstd", bombs.of_zeros("zstd", SIZE), SIZE), "log.too_many_bytes"),
    "an mcap's zstd chunk, of 100 bytes, it says": (
        lambda: mcap_with_chunk("zstd", bombs.of_zeros("zstd", SIZE), 100),
        "log.too_many_bytes",
    ),
    "an mcap's zstd chunk, of no stated size": (
        lambda: mcap_with_chunk("zstd", bombs.of_zeros("zstd, no size", SIZE), 2**64 - 1),
        "log.too_many_bytes",
    ),
    "a gzipped bag": (lambda: bombs.of_zeros("gzip", SIZE, BAG_SKIPPED), "log.too_many_bytes"),
    "a bag in zstd": (lambda: bombs.of_zeros("zstd", SIZE, BAG_SKIPPED), "log.too_many_bytes"),
    "a bag of zeros": (lambda: bombs.of_zeros("zstd", SIZE, BAG), "log.no_scans"),
    "a gzipped mcap": (lambda: bombs.of_zeros("gzip", SIZE, MCAP_SKIPPED), "log.too_many_bytes"),
    "a gzipped mcap of one message": (
        lambda: bombs.of_zeros("gzip", SIZE, MCAP + struct.pack("<BQ", 5, 1 << 40)),
        "log.too_many_bytes",
    ),
    "a gzipped text": (lambda: bombs.of_zeros("gzip", SIZE, TEXTS["carmen raw"].encode()), "log.line_too_long"),
    "a text in zstd": (lambda: bombs.of_zeros("zstd", SIZE, TEXTS["csv"].encode()), "log.line_too_long"),
    # The last, for it takes most.
    "a gzipped db3": (lambda: bombs.of_zeros("gzip", SIZE, SQLITE), "log.too_many_bytes"),
}


@pytest.mark.sampled
@pytest.mark.skipif(not Path("/proc/self/status").is_file(), reason="what a process held at most is read there")
def test_files_that_expand_to_4_gib_are_refused_in_bounded_memory(tmp_path):
    paths = []
    for number, (make, _) in enumerate(CASES.values()):
        paths.append(tmp_path / f"{number}.log")
        paths[-1].write_bytes(make())
        assert paths[-1].stat().st_size < 20 << 20
    # An eighth of the limits, unless there is time for what they are.
    share = 1 if ALL else 8
    log_bytes, chunk_bytes = DEFAULT_LIMITS.max_unpacked_bytes // share, DEFAULT_LIMITS.max_chunk_bytes // share
    done = subprocess.run(
        [sys.executable, "-m", "tests.hostile.peak", str(log_bytes), str(chunk_bytes), *map(str, paths)],
        cwd=ROOT, capture_output=True, text=True, timeout=1500, check=True,
    )  # fmt: skip
    before, *after = map(json.loads, done.stdout.splitlines())
    assert {case: one["code"] for case, one in zip(CASES, after, strict=True)} == {
        case: code for case, (_, code) in CASES.items()
    }
    for case, one in zip(CASES, after, strict=True):
        # A chunk is held as it grows and as one piece; and the file.
        assert one["bytes"] - before["bytes"] < 2.2 * chunk_bytes + (96 << 20), case


def test_the_bombs_expand_to_the_stated_size(tmp_path):
    """The same makers at a size at which another program unpacks them whole."""
    size = 8 << 20
    head = b"before"
    assert lz4.frame.decompress(bombs.of_zeros("lz4", size)) == bytes(size)
    for kind in ("zstd", "zstd, no size"):
        with zstandard.ZstdDecompressor().stream_reader(bombs.of_zeros(kind, size, head)) as stream:
            assert stream.read() == head + bytes(size)
    packed = bombs.of_zeros("bz2", 100_000_000)
    from bz2 import decompress  # which checks the checksums of the blocks and of the whole

    assert len(decompress(packed)) == 120_000_000
    with gzip.open(_file(tmp_path, bombs.of_zeros("gzip", size, head))) as file:
        assert file.read(len(head) + size) == head + bytes(size)


def _file(folder: Path, data: bytes) -> Path:
    path = folder / "a.gz"
    path.write_bytes(data)
    return path


def test_a_zstd_window_of_terabytes_is_refused(tmp_path):
    # A frame header that asks for the largest window there is, then a raw block.
    frame = b"\x28\xb5\x2f\xfd" + bytes([0x00, 0xFF]) + b"\x01\0\0"
    path = tmp_path / "a.log"
    assert isinstance(opened(path, mcap_with_chunk("zstd", frame, 0)), ReadError)
    assert isinstance(opened(path, frame), ReadError)


@pytest.mark.parametrize("pack", [gzip.compress, zstandard.compress], ids=["gzip", "zstd"])
def test_packed_data_within_packed_data_is_named(tmp_path, pack):
    error = opened(tmp_path / "a.log", gzip.compress(pack(TEXTS["carmen raw"].encode())))
    assert isinstance(error, ReadError)
    assert "within packed data (unpack it once)" in error.message


@pytest.mark.parametrize(
    "file",
    [
        # A chunk of the smallest records that there can be, which would take minutes to pass over.
        lambda: bag_with_chunk("bz2", _bz2(bag_record({"op": b"\x02"}, b"") * 30_000)),
        lambda: mcap_with_chunk("zstd", zstandard.compress(struct.pack("<BQ", 0x7F, 0) * 30_000), 270_000),
    ],
    ids=["bag", "mcap"],
)
def test_more_records_than_the_limit(tmp_path, file):
    error = opened(tmp_path / "a.log", file(), replace(DEFAULT_LIMITS, max_messages=20_000))
    assert isinstance(error, LimitError)
    assert error.code == "log.too_many_messages"


def _bz2(data: bytes) -> bytes:
    import bz2

    return bz2.compress(data)


def test_other_packings_are_named(tmp_path):
    error = opened(tmp_path / "a.log", lzma.compress(TEXTS["carmen raw"].encode()))
    assert isinstance(error, ReadError)
    assert "xz data" in error.message


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_chunks_that_are_small_each_and_too_much_together(tmp_path, kind):
    zeros = bytes(1 << 20)
    one = bag_with_chunk("bz2", _bz2(zeros)) if kind == "bag" else mcap_with_chunk("zstd", zstandard.compress(zeros), 0)
    magic = 13 if kind == "bag" else 8
    few = replace(DEFAULT_LIMITS, max_unpacked_bytes=4 << 20)
    error = opened(tmp_path / "a.log", one + one[magic:] * 4, few)
    assert isinstance(error, LimitError)
    assert error.code == "log.too_many_bytes"
    assert isinstance(opened(tmp_path / "a.log", one + one[magic:] * 2, few), ReadError)
