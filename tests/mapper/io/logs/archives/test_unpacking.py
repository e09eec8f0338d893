"""Compressed and marked files: several gzip members, zstd, a byte order mark."""

from __future__ import annotations

import gzip
import zlib
from pathlib import Path

import numpy as np
import pytest
import zstandard

from mapper.core.errors import ReadError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.logs import is_log, open_log
from mapper.io.logs.archives.unpacking import PIECE, Unpacked
from tests.hostile.corpus import TEXTS, recording


def pieces(path: Path, data: bytes) -> tuple[list[bytes], str | None]:
    """Unpacked pieces of a file with ``data``, and the damage that is found."""
    path.write_bytes(data)
    with path.open("rb") as file:
        stream = Unpacked(file, lambda: "here", DEFAULT_LIMITS)
        return list(stream), stream.broken


@pytest.mark.parametrize("pack", [bytes, gzip.compress, zstandard.compress], ids=["plain", "gzip", "zstd"])
def test_the_pieces_add_up_to_the_whole_and_none_is_empty_or_too_long(tmp_path, pack):
    noise = np.random.default_rng(1).integers(0, 256, 3 * PIECE + 17, dtype=np.uint8).tobytes() + bytes(5 * PIECE)
    found, broken = pieces(tmp_path / "a", pack(noise))
    assert b"".join(found) == noise
    assert 0 < min(map(len, found)) <= max(map(len, found)) <= PIECE
    assert broken is None
    packed = pack(noise)
    if pack is not bytes:
        found, broken = pieces(tmp_path / "a", packed[: len(packed) // 2])
        assert noise.startswith(b"".join(found))
        assert broken == "ends early"


@pytest.mark.parametrize("pack", [gzip.compress, zstandard.ZstdCompressor(write_checksum=True).compress])
def test_data_before_a_damaged_block_is_read(tmp_path, pack):
    """The bytes before the damage are the data's own, to within a block of Zstandard (128 KiB) and a symbol of gzip."""
    letters = np.random.default_rng(3).choice(np.frombuffer(b"0123456789. \n", np.uint8), 4 * PIECE).tobytes()
    packed = bytearray(pack(letters))
    at = len(packed) // 2
    packed[at : at + 40] = bytes(range(40, 80))
    found, broken = pieces(tmp_path / "a", bytes(packed))
    assert broken == "is damaged"
    sound = zlib.decompressobj(31).decompress(bytes(packed[:at])) if pack is gzip.compress else letters[:PIECE]
    assert len(sound) >= PIECE
    assert b"".join(found).startswith(sound)


def test_gzip_members_may_begin_and_end_at_any_offset(tmp_path):
    """A piece of the file that holds no more than the header of a member gives nothing, and is not the end."""
    first = np.random.default_rng(2).integers(0, 256, PIECE, dtype=np.uint8).tobytes()
    rest = b"the rest"
    member = gzip.compress(first[:-200], mtime=0)
    for missing in range(30):
        # A name in the header makes the first member so long that the second one's header lies across the border.
        fill = PIECE - missing - len(member) - 1
        named = member[:3] + bytes([8]) + member[4:10] + b"n" * fill + b"\0" + member[10:]
        assert len(named) == PIECE - missing
        found, broken = pieces(tmp_path / "a", named + gzip.compress(b"") + gzip.compress(rest) + bytes(100))
        assert b"".join(found) == first[:-200] + rest
        assert broken is None


@pytest.mark.parametrize("kind", ["bag-none", "mcap-none", "db3", *TEXTS])
def test_an_empty_member_before_the_log(tmp_path, kind):
    data = TEXTS[kind].encode() if kind in TEXTS else recording(kind)
    path = tmp_path / "a"
    path.write_bytes(data)
    plain = open_log(path)
    path.write_bytes(gzip.compress(b"") + gzip.compress(data[:100]) + gzip.compress(data[100:]))
    assert is_log(path)
    again = open_log(path)
    np.testing.assert_array_equal(again.ranges, plain.ranges)
    assert again.notes == plain.notes


@pytest.mark.parametrize("kind", TEXTS)
@pytest.mark.parametrize(
    "change",
    [
        zstandard.compress,
        lambda data: b"\xef\xbb\xbf" + data,
        lambda data: gzip.compress(b"\xef\xbb\xbf" + data),
        lambda data: data.replace(b"\n", b"\r\n"),
    ],
    ids=["zstd", "byte order mark", "byte order mark in gzip", "CR LF"],
)
def test_a_text_as_other_programs_write_it(tmp_path, kind, change):
    path = tmp_path / "a"
    path.write_text(TEXTS[kind])
    plain = open_log(path)
    path.write_bytes(change(TEXTS[kind].encode()))
    again = open_log(path)
    np.testing.assert_array_equal(again.ranges, plain.ranges)
    assert (again.format, again.notes) == (plain.format, plain.notes)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
def test_utf_16_is_named(tmp_path, encoding):
    path = tmp_path / "a"
    mark = {"utf-16-le": "\ufeff", "utf-16-be": "\ufeff"}.get(encoding, "")
    path.write_bytes((mark + TEXTS["csv"]).encode(encoding))
    with pytest.raises(ReadError, match="UTF-16"):
        open_log(path)
