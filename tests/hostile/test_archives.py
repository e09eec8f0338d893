"""Hostile tar archives: nothing is unpacked, no name is used as a path, and valid members are read."""

from __future__ import annotations

import io
import tarfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.logs import open_log
from mapper.sensors.scan import ScanLog
from tests.hostile.archives import tarred
from tests.hostile.corpus import SONAR_POSES, SONAR_READINGS, TEXTS, recording
from tests.hostile.damage import ALL, ROUNDS, flipped, opened

CARMEN = TEXTS["carmen raw"].encode()
SPLIT = {"run/metadata.yaml": b"a: 1\n", "run/run_0.db3": recording("db3"), "run/run_1.db3": recording("db3")}
RING = {"measurement.txt": SONAR_READINGS.encode(), "poses.txt": SONAR_POSES.encode()}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "a.tar"


@pytest.mark.sampled
@pytest.mark.parametrize("files", [SPLIT, RING], ids=["split", "ring"])
def test_every_prefix_of_an_archive(path, files):
    data = tarred(files)
    whole = opened(path, data)
    assert isinstance(whole, ScanLog)
    counts = []
    for n in range(0, len(data), 1 if ALL else max(1, len(data) // 60)):
        log = opened(path, data[:n])
        counts.append(log.n_scans if isinstance(log, ScanLog) else 0)
        if isinstance(log, ScanLog):
            assert np.array_equal(log.ranges, whole.ranges[: log.n_scans], equal_nan=True)
    assert counts[0] == 0
    assert max(counts) > 0


@pytest.mark.sampled
@pytest.mark.parametrize("files", [SPLIT, RING], ids=["split", "ring"])
def test_flipped_bits_in_an_archive(path, files):
    data = tarred(files)
    rng = np.random.default_rng(len(data))
    heads = [at for at in range(0, len(data), 512) if data[at + 257 : at + 262] == b"ustar"]
    logs = 0
    for i in range(ROUNDS):
        at = heads[i % len(heads)]  # most of its bytes are the files'
        damaged = data[:at] + flipped(rng, data[at : at + 512]) + data[at + 512 :] if i % 2 else flipped(rng, data)
        logs += isinstance(opened(path, damaged), ScanLog)
    assert 0 < logs < ROUNDS


@pytest.mark.parametrize("number", [b"77777777777\0", b"\xff" * 12, b"\x80" + bytes(3) + b"\xff" * 8, b"-0000000010\0"])
def test_a_size_that_lies(path, number):
    data = bytearray(tarred({"a.log": CARMEN, "poses.txt": b""}, tarfile.USTAR_FORMAT))
    data[124:136] = number
    data[148:156] = b" " * 8
    data[148:156] = b"%06o\0 " % sum(data[:512])
    log = opened(path, bytes(data))
    notes = log.notes if isinstance(log, ScanLog) else ["The archive ends early: only what precedes is read."]
    assert "The archive ends early: only what precedes is read." in notes


def test_links_devices_and_path_names_in_archives_have_no_effect(path):
    """A link to the machine's own files gives nothing of them, and a name is no path."""
    secret = path.with_name("secret.log")
    secret.write_bytes(CARMEN)
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as archive:
        for kind in (tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.CHRTYPE, tarfile.FIFOTYPE, tarfile.DIRTYPE):
            info = tarfile.TarInfo(f"../secret.{kind.decode()}.log")
            info.type, info.linkname = kind, str(secret)
            archive.addfile(info)
    error = opened(path, out.getvalue())
    assert isinstance(error, ReadError)
    assert error.code == "log.folder"
    names = ("../" * 40 + "etc/passwd", "a\0b.log", "\u202egol.a", "n" * 4000, "<script>", "a\\b\\..\\c")
    for name in names:
        log = opened(path, tarred({name: CARMEN}))
        assert isinstance(log, ScanLog)
        assert log.name.isprintable()
        assert "/" not in log.name
        assert len(log.name) <= 200
    assert sorted(one.name for one in path.parent.iterdir()) == ["a.tar", "secret.log"]


def test_archives_of_very_many_and_within_archives(path):
    few = replace(DEFAULT_LIMITS, max_archive_files=50)
    assert isinstance(opened(path, tarred({f"{i}.txt": b"" for i in range(51)}), few), LimitError)
    folder = path.parent / "many"
    folder.mkdir()
    for i in range(51):
        (folder / f"{i}.log").write_bytes(CARMEN)
    with pytest.raises(LimitError, match="more than 50 files"):
        open_log(folder, limits=few)
    nested = opened(path, tarred({"in.tar": tarred({"a.log": CARMEN})}))
    assert isinstance(nested, ReadError)
    assert nested.code == "log.archive"
    # A thousand records of a name, one after the other: a reader that calls itself for each would run out of stack.
    chain = tarred({"n" * 300: b""}, tarfile.GNU_FORMAT)[:1024] * 3000
    assert isinstance(opened(path, chain + tarred({"a.log": CARMEN})), ScanLog)


def test_a_header_that_has_another_checksum_ends_the_archive(path):
    data = bytearray(tarred({"a.log": CARMEN, "b.log": CARMEN}, tarfile.USTAR_FORMAT))
    second = 512 + -(-len(CARMEN) // 512) * 512
    data[second] ^= 1  # of the second file's name
    log = opened(path, bytes(data))
    assert isinstance(log, ScanLog)
    assert log.notes[0] == f"The archive is damaged at byte {second}: only what precedes is read."
    data[0] ^= 1
    error = opened(path, bytes(data))
    assert isinstance(error, ReadError)
    assert error.code == "log.archive"
