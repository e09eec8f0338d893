"""Logs that are wrong, truncated, absurd or malicious: each has its own error, which states the place."""

from __future__ import annotations

import gzip
import tracemalloc
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import LimitError, MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.io.logs import open_log

GOOD = "FLASER 4 1.0 2.0 3.0 4.0 0.1 0.2 0.3 0.1 0.2 0.3 12.5 host 12.5"
ODOM = "ODOM 0.1 0.2 0.3 0 0 0 12.4 host 12.4"
ROBOT = "ROBOTLASER1 0 -1.57 3.14 0.785 50 0.1 0 4 1 2 3 4 0 0 0 0 0 0 0 0 0 0 0 0 12.5 host 12.5"


def refused(folder: Path, data: bytes, limits: Limits = DEFAULT_LIMITS) -> MapperError:
    path = folder / "a.log"
    path.write_bytes(data)
    with pytest.raises(MapperError) as caught:
        open_log(path, limits=limits)
    assert str(folder) not in caught.value.message, "an error must not tell where files lie on the server"
    return caught.value


LINES = {
    # what follows two good lines: the code, words of the message
    "cut in the ranges": ("FLASER 4 1.0 2.0", "log.truncated_line", "ends early"),
    "cut before the stamp": ("FLASER 4 1 2 3 4 0 0 0 0 0 0", "log.truncated_line", "needs 13 fields, but has 12"),
    "cut after the word": ("FLASER", "log.truncated_line", "ends after its first word"),
    "odometry cut": ("ODOM 1 2", "log.truncated_line", "ODOM line ends early"),
    "true pose cut": ("TRUEPOS 1 2", "log.truncated_line", "TRUEPOS line ends early"),
    "robot laser cut": ("ROBOTLASER1 0 -1.57", "log.truncated_line", "before its number of beams"),
    "robot laser cut in the ranges": (ROBOT[:50], "log.truncated_line", "ends early"),
    "garbage": ("81.83 0.5 hello", "log.garbage", "not a CARMEN message"),
    "not ASCII": ("\xff\xfe\x01", "log.garbage", "not a CARMEN message"),
    "a reading that is no number": (GOOD.replace("3.0", "3.O"), "log.not_a_number", "'3.O'"),
    "a number with an underscore": (GOOD.replace("3.0", "3_0"), "log.not_a_number", "'3_0'"),
    "a reading of 1e999": (GOOD.replace("3.0", "1e999"), "log.not_a_number", "'1e999' in this FLASER"),
    "a pose of nan": (GOOD.replace("0.1", "nan", 1), "log.pose", "the laser’s pose in this FLASER line is not finite"),
    "a pose of inf": (GOOD.replace("0.1", "inf", 1), "log.pose", "is not finite"),
    "a robot pose of nan": (GOOD.replace(" 0.1 0.2 0.3 12", " 0.1 0.2 nan 12"), "log.pose", "the robot’s pose"),
    "a pose on the moon": (GOOD.replace("0.1", "3.8e8", 1), "log.pose", "lies beyond"),
    "an odometry pose of nan": (ODOM.replace("0.1", "nan"), "log.pose", "ODOM line is not finite"),
    "a stamp of nan": (GOOD.replace("12.5 host", "nan host"), "log.stamp", "the time 'nan'"),
    "a stamp beyond 64 bits": (GOOD.replace("12.5 host", "1e12 host"), "log.stamp", "impossible"),
    "more beams stated": (GOOD.replace("FLASER 4", "FLASER 5"), "log.beam_count", "states 5 beams"),
    "fewer beams stated": (GOOD.replace("FLASER 4", "FLASER 1"), "log.beam_count", "states 1 beams"),
    "no beams stated": (GOOD.replace("FLASER 4", "FLASER 0"), "log.beam_count", "'0' as the number of beams"),
    "minus beams stated": (GOOD.replace("FLASER 4", "FLASER -4"), "log.beam_count", "'-4' as the number of beams"),
    "half a beam stated": (GOOD.replace("FLASER 4", "FLASER 4.5"), "log.beam_count", "'4.5' as the number of beams"),
    "a number of beams of many digits": (GOOD.replace("FLASER 4", "FLASER " + "9" * 5000), "log.beam_count", "999"),
    "an impossible mount": ("PARAM robot_frontlaser_offset nan x 0", "log.parameter", "cannot be 'nan' m"),
    "a mount that is no number": ("PARAM robot_frontlaser_offset ahead x 0", "log.not_a_number", "'ahead'"),
    "a maximum range of nan": ("PARAM robot_frontlaser_max nan x 0", "log.parameter", "cannot be 'nan' m"),
    "robot laser without field of view": (ROBOT.replace("3.14", "0"), "log.beam_angles", "impossible angles"),
    "robot laser with a start of nan": (ROBOT.replace("-1.57", "nan"), "log.beam_angles", "impossible angles"),
    "robot laser with many remissions": (ROBOT.replace("4 0 0", "4 9 0"), "log.beam_count", "4 beams and 9 remissions"),
}  # fmt: skip


@pytest.mark.parametrize("case", LINES)
def test_errors_of_a_bad_line_name_it_and_the_reason(tmp_path, case):
    line, code, words = LINES[case]
    error = refused(tmp_path, f"{GOOD}\n{ODOM}\n{line}\n{GOOD}\n".encode("latin-1"))
    assert isinstance(error, ReadError)
    assert error.code == code
    assert words in error.message
    assert error.message.startswith("Line 3")
    assert len(error.message) < 300


def test_too_many_beams_scans_or_readings_exceed_the_limits(tmp_path):
    text = f"{GOOD}\n".encode() * 10
    few_beams = refused(tmp_path, text, replace(DEFAULT_LIMITS, max_beams=3))
    assert (type(few_beams), few_beams.code) == (LimitError, "log.too_many_beams")
    for limits in (replace(DEFAULT_LIMITS, max_scans=9), replace(DEFAULT_LIMITS, max_readings=39)):
        error = refused(tmp_path, text, limits)
        assert (type(error), error.code) == (LimitError, "log.too_many_scans")
        assert "Line 10" in error.message


def test_more_lines_than_the_limit_are_refused_before_they_are_read(tmp_path):
    text = f"{GOOD}\n".encode() + b"\n" * 1000
    error = refused(tmp_path, text, replace(DEFAULT_LIMITS, max_lines=1000))
    assert (type(error), error.code) == (LimitError, "log.too_many_lines")


def test_an_empty_file(tmp_path):
    assert refused(tmp_path, b"").code == "log.empty"
    assert refused(tmp_path, gzip.compress(b"")).code == "log.empty"


def test_a_log_without_scans(tmp_path):
    for text in (f"{ODOM}\n", "# CARMEN Logfile\n#\n", "\n\n\n", "PARAM a b\n"):
        error = refused(tmp_path, text.encode())
        assert error.code == "log.no_scans", text
        assert "no scans" in error.message
    assert refused(tmp_path, b"Odometry 1 2 3\n").code == "log.no_scans"


@pytest.mark.parametrize(
    ("data", "code", "words"),
    [
        (b"Dear robot,\nhow are you?\n", "log.unknown_format", "'Dear robot,'"),
        (b"#ROSBAG V2.0\n\x45\0\0\0", "log.no_scans", "no messages; the bag ends early, at byte 17"),
        (b"\x89PNG\r\n\x1a\n\0\0", "log.unknown_format", "a PNG picture"),
        (b"\x28\xb5\x2f\xfd\0\0", "log.truncated", "ends early"),
        (
            b"PARAM robot_frontlaser_offset 0,2 a 0\n",
            "log.not_a_number",
            "'0,2' in this PARAM line is not a number with",
        ),
        (b"BZh91AY&SY", "log.unknown_format", "bzip2 data (unpack it)"),
        (b"\x04\x22\x4d\x18\x64\x40\xa7", "log.unknown_format", "lz4 data (unpack it)"),
        (b"# stamps\n1.7e9 1 2 0 0 0 0.6 0.8\n1.7e9 1 2 0 0 0 0 1\n", "log.poses", "a trajectory in the format TUM"),
        (b"1.7e9 1 2 0 0 0 0.6 0.8\n1.7e9 1 2 0 0 0 1 1\n", "log.unknown_format", "starts with '1.7e9"),
        (b"VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n", "log.poses", "a pose graph in the format g2o"),
        (bytes(range(256)) * 20, "log.binary", "binary"),
    ],
)
def test_files_that_are_no_logs(tmp_path, data, code, words):
    error = refused(tmp_path, data)
    assert error.code == code
    assert words in error.message


def test_a_file_that_is_not_there_and_one_that_is_a_folder(tmp_path):
    with pytest.raises(ReadError, match=r"There is no file 'gone\.log'") as missing:
        open_log(tmp_path / "gone.log")
    with pytest.raises(ReadError, match="The folder holds no log of a known kind") as folder:
        open_log(tmp_path)
    with pytest.raises(ReadError) as nul:
        open_log("a\0b")
    assert (missing.value.code, folder.value.code, nul.value.code) == (
        "log.missing",
        "log.folder",
        "log.unreadable",
    )


def test_a_folder_of_folders_says_which_there_are(tmp_path):
    for name in ("run1", "run2"):
        (tmp_path / name).mkdir()
    with pytest.raises(ReadError, match="holds folders alone, 'run1', 'run2': open the one with the recording"):
        open_log(tmp_path)


def test_a_text_file_truncated_within_a_line_keeps_its_complete_scans(tmp_path):
    path = tmp_path / "a.log"
    path.write_text(f"{GOOD}\n{GOOD}\n{GOOD[:40]}")
    log = open_log(path)
    assert log.n_scans == 2
    assert "The file ends in the middle of line 3, which is left out." in log.notes


def test_a_text_file_that_ends_in_the_middle_of_its_first_scan_is_refused(tmp_path):
    assert refused(tmp_path, f"{ODOM}\n{GOOD[:40]}".encode()).code == "log.truncated_line"


def test_a_truncated_gzip_file_keeps_its_complete_scans_and_notes_its_last_line(tmp_path):
    rng = np.random.default_rng(1)
    lines = [GOOD.replace("3.0", f"{reading:.3f}") for reading in rng.uniform(1, 9, 2000)]
    packed = gzip.compress("".join(line + "\n" for line in lines).encode())
    path = tmp_path / "a.log.gz"
    path.write_bytes(packed[: len(packed) // 2])
    # What a streaming decompressor gets out of the same bytes is the answer to compare with.
    whole_lines = zlib.decompressobj(31).decompress(packed[: len(packed) // 2]).count(b"\n")
    log = open_log(path)
    assert 0 < log.n_scans == whole_lines < 2000
    assert f"The gzip data ends early, after line {whole_lines}: the rest of the log is missing." in log.notes


def test_a_gzip_file_cut_before_any_scan_is_refused(tmp_path):
    packed = gzip.compress(f"{GOOD}\n".encode() * 5)
    for kept in (3, 12, 20):
        error = refused(tmp_path, packed[:kept])
        assert error.code == "log.truncated"
        assert "ends early" in error.message


def packed_log(n: int = 2500) -> tuple[list[str], bytearray]:
    """The lines of a log, no two alike, and the whole as gzip."""
    rng = np.random.default_rng(2)
    lines = [GOOD.replace("3.0", f"{reading:.6f}") for reading in rng.uniform(1, 9, n)]
    return lines, bytearray(gzip.compress("".join(f"{line}\n" for line in lines).encode()))


def test_of_gzip_data_that_is_damaged_in_its_middle_the_scans_before_are_there_and_it_is_marked(tmp_path):
    lines, good = packed_log()
    path = tmp_path / "a.log.gz"
    path.write_text("".join(f"{line}\n" for line in lines))
    whole = open_log(path)
    rng = np.random.default_rng(5)
    for _ in range(12):
        packed = bytearray(good)
        at = int(rng.integers(len(packed) // 3, len(packed) - 8))
        packed[at : at + 3] = rng.integers(0, 256, 3, dtype=np.uint8).tobytes()
        # What comes out of the bytes before the damage is the answer to compare with.
        sound = zlib.decompressobj(31).decompress(bytes(packed[:at])).count(b"\n")
        path.write_bytes(packed)
        log = open_log(path)
        assert sound <= log.n_scans <= len(lines)
        np.testing.assert_array_equal(log.ranges[:sound], whole.ranges[:sound])
        assert packed == good or any("The gzip data is damaged: what precedes line" in note for note in log.notes)


def test_gzip_data_with_another_checksum_than_its_own_is_marked(tmp_path):
    lines, packed = packed_log(100)
    packed[-5] ^= 0xFF
    path = tmp_path / "a.log.gz"
    path.write_bytes(packed)
    log = open_log(path)
    assert log.n_scans == len(lines)
    assert any("The gzip data is damaged" in note for note in log.notes)


def test_gzip_data_that_expands_to_nothing_is_refused(tmp_path):
    assert refused(tmp_path, b"\x1f\x8bhello").code == "log.gzip"
    packed = bytearray(gzip.compress(f"{GOOD}\n".encode()))
    packed[12:20] = b"\xff" * 8
    assert refused(tmp_path, bytes(packed)).code in ("log.gzip", "log.truncated")


def test_a_wrong_line_in_good_gzip_data_is_named(tmp_path):
    """Only where the packing is damaged the lines are not to blame."""
    lines, _ = packed_log(100)
    error = refused(tmp_path, gzip.compress("\n".join([*lines, "garbage", *lines, ""]).encode()))
    assert (error.code, error.message.startswith("Line 101")) == ("log.garbage", True)


@pytest.fixture
def peak_memory():
    """A function that tells how many bytes Python has held at most since the test began."""
    tracemalloc.start()
    yield lambda: tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()


@pytest.mark.parametrize(
    ("line", "code"),
    [
        (b"\0", "log.line_too_long"),
        (b"1 ", "log.line_too_long"),
        (b"\n", "log.too_many_lines"),
        (b"# bomb of comments\n", "log.too_many_bytes"),
    ],
    ids=["zeros", "one line", "empty lines", "comments"],
)
def test_a_gzip_bomb_is_refused_in_little_memory(tmp_path, peak_memory, line, code):
    limits = replace(DEFAULT_LIMITS, max_unpacked_bytes=6 << 20, max_expansion=1, max_lines=500_000)
    stream = zlib.compressobj(9, wbits=31)
    packed = stream.compress(f"{GOOD}\n".encode())
    for _ in range(32):
        packed += stream.compress(line * ((1 << 20) // len(line)))
    packed += stream.flush()
    assert len(packed) < 300_000
    tracemalloc.reset_peak()
    error = refused(tmp_path, packed, limits)
    assert peak_memory() < 12 << 20
    assert isinstance(error, LimitError)
    assert error.code == code


def test_a_line_of_100_megabytes_is_refused_without_being_held(tmp_path, peak_memory):
    path = tmp_path / "a.log"
    with path.open("wb") as file:
        file.write(f"{GOOD}\n".encode())
        for _ in range(100):
            file.write(b"FLASER 1 " + b"1 " * 500_000)
    tracemalloc.reset_peak()
    with pytest.raises(LimitError, match="Line 2 is longer than the limit") as caught:
        open_log(path)
    assert peak_memory() < 12 << 20
    assert caught.value.code == "log.line_too_long"
