"""The lines of /rosout and the changes on /diagnostics against what rosbags wrote."""

from __future__ import annotations

from pathlib import Path

import pytest

from mapper.io.contents import log_lines
from mapper.io.contents.inspection import inspect
from mapper.io.contents.log_lines import ERROR, INFO, WARN, LineReader
from mapper.io.logs.ros.message_fields import BadMessageError
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.logs import recorded
from tests.mapper.io.logs.recorded import SECOND


@pytest.mark.parametrize("kind", recorded.KINDS)
def test_each_line_with_its_time_level_node_and_text(tmp_path: Path, kind: str) -> None:
    ros = 1 if kind == "bag" else 2
    warning, error = (4, 8) if ros == 1 else (30, 40)
    said = [
        *robot(1),
        recorded.log_line(T0 + SECOND, warning, "\x1b[33mWheel\nslips\x1b[0m", ros=ros),
        recorded.log_line(T0 + 2 * SECOND, error, "Bumper pressed", "bumper", ros=ros),
    ]
    contents = inspect(recorded.written(tmp_path, said, kind))
    assert [(line.stamp_ns - T0, line.level, line.name, line.text) for line in contents.lines] == [
        (SECOND, WARN, "base", "Wheel slips"),
        (2 * SECOND, ERROR, "bumper", "Bumper pressed"),
    ]
    assert {line.topic for line in contents.lines} == {"/rosout"}
    assert contents.lines_left_out == 0
    assert contents.notes == ()


def test_of_states_that_are_repeated_the_changes_are_listed(tmp_path: Path) -> None:
    states = [(0, ""), (0, ""), (1, "Hot"), (1, "Hot"), (3, ""), (0, "")]
    said = [recorded.diagnostics(T0 + n * SECOND, {"motor": state, "lidar": (0, "")}) for n, state in enumerate(states)]
    contents = inspect(recorded.written(tmp_path, [*robot(1), *said], "mcap"))
    own = [((line.stamp_ns - T0) // SECOND, line.level, line.text) for line in contents.lines if line.name == "motor"]
    assert own == [(0, INFO, "OK"), (2, WARN, "Hot"), (4, WARN, "Stale"), (5, INFO, "OK")]
    assert len([line for line in contents.lines if line.name == "lidar"]) == 1


def test_many_lines_leave_no_later_error_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_lines, "MAX_LINES", 3)
    reader = LineReader()
    for n in range(6):
        line = recorded.log_line(T0 + n, 40 if n == 5 else 20, "x" * 2000)
        reader.take("rcl_interfaces/Log", "/rosout", line.stamp_ns, recorded.serialised(line, 2), cdr=True)
    assert [(line.stamp_ns - T0, line.level) for line in reader.lines] == [(0, INFO), (1, INFO), (2, INFO), (5, ERROR)]
    assert reader.left_out == 2
    assert len(reader.lines[0].text) == log_lines.MAX_TEXT + 2


def test_a_line_without_a_time_has_that_of_its_recording_and_a_cut_message_is_refused() -> None:
    reader = LineReader()
    data = recorded.serialised(recorded.log_line(0, 20, "Ready"), 2)
    reader.take("rcl_interfaces/Log", "/rosout", T0, data, cdr=True)
    assert (reader.lines[0].stamp_ns, reader.lines[0].is_recorded) == (T0, True)
    for end in range(data.index(b"Ready")):
        with pytest.raises(BadMessageError):
            reader.take("rcl_interfaces/Log", "/rosout", T0, data[:end], cdr=True)
