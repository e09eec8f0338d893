"""Comma-separated scans: the documented format is read, and errors are stated with their line."""

from __future__ import annotations

import gzip
import re

import numpy as np
import pytest

from mapper.core.errors import MapperError
from mapper.io.logs import is_log, open_log
from mapper.io.logs.text import csv_scans

HEAD = "angle_min,-1\nangle_increment,0.5\nrange_min,0.05\nrange_max,30\n"
COLUMNS = "stamp,x,y,theta,ranges\n"


def test_the_example_in_the_documentation(tmp_path):
    example = re.search(r"::\n\n((?:    .*\n)+)", csv_scans.__doc__ or "")
    assert example is not None
    path = tmp_path / "a.csv"
    path.write_text(example[1].replace("    ", ""))
    assert is_log(path)
    log = open_log(path)
    expected = np.array([[2.31, 2.30, np.inf, 2.28], [2.21, np.nan, np.nan, 2.18]], dtype=np.float32)
    np.testing.assert_array_equal(log.ranges, expected)
    assert (log.angle_min, log.angle_increment, log.range_min, log.range_max) == (-1.5708, 0.0174533, 0.05, 30.0)
    assert log.stamps_ns.tolist() == [12_500_000_000, 12_600_000_000]
    np.testing.assert_array_equal(log.trajectory("scan").poses, [[0, 0, 0], [0.1, 0, 0]])


def test_remarks_spaces_mounts_and_the_range_limits(tmp_path):
    path = tmp_path / "a.csv.gz"
    text = "# made by hand\n" + HEAD + "mount_x, 0.2\nmount_yaw,0.1\n\n" + COLUMNS + "0, 0,0,0, 30 , 30.01,-1,0\n"
    path.write_bytes(gzip.compress(text.replace("\n", "\r\n").encode()))
    log = open_log(path)
    np.testing.assert_array_equal(log.ranges, np.array([[30, np.inf, np.nan, np.nan]], dtype=np.float32))
    assert log.mount == (0.2, 0.0, 0.1)
    assert log.time_increment == 0.0


@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_what_spreadsheets_of_other_countries_save(tmp_path, separator, decimal):
    text = HEAD + COLUMNS + "0.5,1.25,0,-0.5,2.31,,inf\n" + "1.5,2,0,0,2.5,3.5,nan\n"
    plain, saved = tmp_path / "plain.csv", tmp_path / "saved.csv"
    plain.write_text(text)
    saved.write_text("\ufeff" + text.replace(",", separator).replace(".", decimal) + 6 * separator + "\n")
    assert is_log(saved)
    expected, log = open_log(plain), open_log(saved)
    np.testing.assert_array_equal(log.ranges, expected.ranges)
    np.testing.assert_array_equal(log.trajectory().poses, expected.trajectory().poses)
    assert log.stamps_ns.tolist() == expected.stamps_ns.tolist() == [500_000_000, 1_500_000_000]


@pytest.mark.parametrize(
    "text",
    [
        (
            "angle_min_deg,-90\nangle_increment_deg,60\nrange_max_mm,4000\nmount_x_cm,20\n"
            "stamp_ms,x_mm,y_mm,theta_deg,ranges_mm\n500,1250,-300,90,2310,inf,,2500\n"
        ),
        (
            "angle_min (deg);-90\nangle_increment (deg);60\nrange_max [cm];400\nmount_x;0,2\n"
            "stamp [ns];x [cm];y [cm];theta (deg);ranges (cm)\n500000000;125;-30;90;231,0;inf;nan;250,0\n"
        ),
    ],
)
def test_names_may_state_other_units(tmp_path, text):
    path = tmp_path / "a.csv"
    path.write_text(text)
    assert is_log(path)
    log = open_log(path)
    assert (log.angle_min, log.angle_increment) == pytest.approx((-np.pi / 2, np.pi / 3))
    assert (log.range_max, log.mount[0]) == pytest.approx((4.0, 0.2))
    np.testing.assert_allclose(log.ranges, np.array([[2.31, np.inf, np.nan, 2.5]]), rtol=1e-6)
    np.testing.assert_allclose(log.trajectory().poses, [[1.25, -0.3, np.pi / 2]])
    assert log.stamps_ns.tolist() == [500_000_000]
    (note,) = [note for note in log.notes if "other units" in note]
    assert note.endswith("state other units than the format has: they are converted to metres, radians and seconds.")


def test_quoted_fields(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text('"angle_min","-1,5"\n"angle_increment","0,5"\n' + COLUMNS + '"0","1,25","0","0","2,5","3"\n')
    log = open_log(path)
    assert (log.angle_min, log.ranges.tolist()) == (-1.5, [[2.5, 3.0]])
    assert log.trajectory().poses.tolist() == [[1.25, 0.0, 0.0]]


@pytest.mark.parametrize("separator", [",", ";"])
def test_quoted_remarks(tmp_path, separator):
    path = tmp_path / "a.csv"
    text = HEAD + COLUMNS + '"# a door, opened; 1"\n' + "0,1.25,0,0,2.5,3\n"
    text = text.replace("range_min", '"# office, 2nd; east"\nrange_min').replace("angle_min", '"# office"\nangle_min')
    if separator == ";":
        text = re.sub('^[^"].*$', lambda line: line[0].replace(",", ";"), text, flags=re.MULTILINE)
    path.write_text(text)
    assert is_log(path)
    log = open_log(path)
    assert (log.angle_min, log.range_min, log.ranges.tolist()) == (-1.0, 0.05, [[2.5, 3.0]])


@pytest.mark.parametrize("number", ["1.5", "1.234,5", "1,5m"])
def test_what_is_no_number_with_a_decimal_comma_is_quoted_as_it_stands(tmp_path, number):
    """A point among commas may part thousands, or be of a program that mixes both."""
    path = tmp_path / "a.csv"
    path.write_text("angle_min;-1,5\nangle_increment;0,5\n" + COLUMNS.replace(",", ";") + f"0;0;0;0;{number}\n")
    with pytest.raises(MapperError, match=rf"Line 4: '{re.escape(number)}' .* this file has decimal commas"):
        open_log(path)


def test_the_time_from_beam_to_beam(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(HEAD + "time_increment,0.0005\n" + COLUMNS + "0,0,0,0,1,2\n")
    assert open_log(path).time_increment == 0.0005


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (HEAD + COLUMNS, "log.no_scans", "no line follows"),
        ("angle_min,0\n" + COLUMNS + "0,0,0,0,1\n", "log.header", "Line 2: .* do not state angle_increment"),
        (HEAD + "0,0,0,0,1\n", "log.header", "Line 5: '0' is neither"),
        (HEAD + "speed,3\n", "log.header", "Line 5: 'speed' is neither"),
        (HEAD + "range_min\n", "log.header", "Line 5: range_min needs one value"),
        (HEAD + "range_min,1,2\n", "log.header", "Line 5: range_min needs one value"),
        (HEAD + "range_min,x\n", "log.not_a_number", "Line 5: 'x'"),
        (HEAD + "angle_min,nan\n" + COLUMNS, "log.header", "angle_min cannot be nan"),
        (HEAD + "mount_x,1e9\n" + COLUMNS, "log.header", "mount_x cannot be"),
        (HEAD + COLUMNS + "0,0,0,0\n0,0,0,0,1\n", "log.truncated_line", "Line 6 ends early"),
        (HEAD + COLUMNS + "0,0,0,0,1,2\n0,0,0,0,1\n", "log.beams_vary", "Line 7: .* has 1 beams, but line 6 has 2"),
        (HEAD + COLUMNS + "0,0,0,0,1\n0,nan,0,0,1\n0,0,0,0,1", "log.pose", "Line 7"),
        (HEAD + COLUMNS + "0,0,0,0,1\n1e99,0,0,0,1\n0,0,0,0,1", "log.stamp", "Line 7"),
        (HEAD + COLUMNS + "0,0,0,0,one\n", "log.not_a_number", "Line 6: 'one'"),
        (HEAD + COLUMNS + "0,0,0,0" + ",1" * 20_001 + "\n", "log.too_many_beams", "Line 6 has 20001 ranges"),
    ],
)
def test_errors_name_the_line_and_the_reason(tmp_path, text, code, words):
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(MapperError, match=words) as caught:
        open_log(path)
    assert caught.value.code == code


def test_other_tables_are_no_logs(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time,x,y\n1,2,3\n")
    assert not is_log(path)
