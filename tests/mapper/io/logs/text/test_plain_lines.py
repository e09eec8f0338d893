"""The fast reader of CARMEN lines equals the slow one to the last bit, also in its errors."""

from __future__ import annotations

import math
from pathlib import Path
from unittest.mock import patch

from hypothesis import example, given, settings
from hypothesis import strategies as st

from mapper.core.errors import MapperError
from mapper.io.logs import open_log
from mapper.io.logs.text import fields

NUMBERS = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.decimals(allow_nan=False, allow_infinity=False, places=25).map(lambda value: f"{value:f}"),
    st.integers(-(10**30), 10**30).map(str),
    st.sampled_from(
        ["1e999", "-1e400", "1e-400", "nan", "inf", "-0", "007", "1.", ".5", "+1", "1_0", "0x1", "true", ""]
    ),
)
SPACE = st.sampled_from([" "] * 12 + ["  ", "\t", " \t", "\r", "\x0b", "\x85", "\xa0", ", ", " [", "] ", " \0"])


@given(st.lists(NUMBERS, max_size=8))
@example(["9007199254740993", "2.2250738585072011e-308", "123456789012345678901234567890.5"])
def test_a_plain_list_is_the_same_numbers(tokens: list[str]) -> None:
    text = " ".join(tokens)
    found = fields.listed(text.encode())
    if found is None:
        return
    assert found == [float(token) for token in text.split()]
    assert all(map(math.isfinite, found))


@st.composite
def lines(draw: st.DrawFn) -> str:
    """A laser's line as CARMEN writes it, with a few places that are otherwise."""
    n = draw(st.integers(0, 4))
    tokens = (
        ["1.25"] * n + ["0.5"] * 6 + ["12.5"] + draw(st.sampled_from([["host", "0.5"], [], ["host"], ["a b", "1"]]))
    )
    spaces = [" "] * (len(tokens) + 1)
    for _ in range(draw(st.integers(0, 2))):
        tokens[draw(st.integers(0, len(tokens) - 1))] = draw(NUMBERS)
    for _ in range(draw(st.integers(0, 2))):
        spaces[draw(st.integers(0, len(spaces) - 1))] = draw(SPACE)
    stated = str(n + draw(st.sampled_from([0, 0, 0, 0, 1, -1, 9])))
    return (
        f"FLASER {stated}" + "".join(space + token for space, token in zip(spaces, tokens, strict=False)) + spaces[-1]
    )


@settings(max_examples=400)
@given(lines())
@example("FLASER 3 1.5 1.5 1.5 0 0 0 0 0 0 12.5 host 0.5")
def test_a_line_is_taken_or_refused_alike(tmp_path_factory, text: str) -> None:
    path: Path = tmp_path_factory.getbasetemp() / "plain.log"
    good = "FLASER 2 1.0 2.0 0 0 0 0 0 0 12.5 host 0.5\n"
    path.write_bytes((good * ("FLASER 2 " in text) + text + "\n").encode("latin-1"))

    def told() -> object:
        try:
            log = open_log(path)
        except MapperError as error:
            return (error.code, error.message)
        poses = [trajectory.poses.tobytes() for trajectory in log.trajectories.values()]
        return (log.ranges.tobytes(), log.stamps_ns.tobytes(), poses, log.notes, log.beam_width)

    quick = told()
    with patch("mapper.io.logs.text.fields.listed", lambda _: None):
        assert told() == quick
