"""YAML that PyYAML cannot load, or only slowly, is refused with a sentence by each reader of parameter files."""

from __future__ import annotations

import re
from contextlib import suppress
from typing import Any

import pytest
import yaml
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mapper.core.errors import MapperError
from mapper.costmap.nav2.reading import parse_nav2_costmap
from mapper.io.untrusted_yaml import load_untrusted
from mapper.localization.amcl_parameters import parse_amcl_yaml
from tests.mapper.planning.nav2_file import parse_nav2_path

HOSTILE = {
    "no boolean": ("!!bool perhaps", "'perhaps' is no bool"),
    "no time": ("!!timestamp soon", "'soon' is no timestamp"),
    "no date": ("2001-99-99", "'2001-99-99' is no timestamp"),
    "an integer of 20,000 bits": ("0x" + "f" * 5000, "more than 64 bits"),
    "an integer to the base of 60": (":".join(["59"] * 20_000), "more than 64 bits"),
    "a float to the base of 60": (":".join(["59"] * 200) + ".5", "is no float"),
    "a list within itself": ("[&a [1, *a]]", "'a' is within itself"),
    "deep lists": ("[" * 9000, "nested"),
    "a list of very many values": ("[" + "1," * 30_000 + "1]", "may have at most 10000 keys, values and lists"),
}


@pytest.mark.parametrize("case", HOSTILE)
@pytest.mark.parametrize(
    ("node", "parse"),
    [
        ("amcl:\n  ros__parameters:\n    alpha1", parse_amcl_yaml),
        ("local_costmap:\n  local_costmap:\n    ros__parameters:\n      plugins", parse_nav2_costmap),
        ("planner_server:\n  ros__parameters:\n    tolerance", parse_nav2_path),
    ],
)
def test_each_parameter_file_with_it_is_refused(node, parse, case):
    value, said = HOSTILE[case]
    with pytest.raises(MapperError, match=re.escape(said)) as refused:
        parse(f"{node}: {value}\n".encode())
    assert len(refused.value.message) < 300


LAUGHS = "&a [x, x]" + "".join(f", &{c} [*{p}, *{p}]" for p, c in zip("abcdefghijkl", "bcdefghijklm", strict=True))


def test_values_that_are_named_again_count_again():
    assert load_untrusted("{a: &a [1, 2], b: {<<: &b {c: 3, d: 4}, c: 5}, e: [*a, *b]}") == {
        "a": [1, 2],
        "b": {"c": 5, "d": 4},
        "e": [[1, 2], {"c": 3, "d": 4}],
    }
    assert load_untrusted("[&a [1, 1, 1], " + "*a, " * 2_498 + "1, 1, 1]")[-4] == [1, 1, 1]  # each has four values
    with pytest.raises(yaml.YAMLError, match="more than 10000 values"):
        load_untrusted("[&a [1, 1, 1], " + "*a, " * 2_498 + "1, 1, 1, 1]")
    with pytest.raises(yaml.YAMLError, match="more than 10000 values"):
        load_untrusted(f"[{LAUGHS}]")
    deep = "".join(f", &{c} [[[*{p}]]]" for p, c in zip("abcdef", "bcdefg", strict=True))
    with pytest.raises(yaml.YAMLError, match="nested too deeply"):
        load_untrusted(f"[&a [x]{deep}]")


def test_as_many_values_as_are_allowed_are_loaded():
    # The list is a value too.
    assert load_untrusted("[" + "1," * 9_999 + "]") == [1] * 9_999
    with pytest.raises(yaml.YAMLError, match="more than 10000 values"):
        load_untrusted("[" + "1," * 10_000 + "]")


@pytest.mark.parametrize(
    "text",
    ["\ud800", '"\ud800"', '"\\ud800"', "\0", "\x01", "%TAG ! tag:a:\n", "--- 1\n--- 2", "<<: 3", "? [1]\n: 2", "{"],
)
def test_text_that_is_no_yaml_is_refused_as_such(text):
    with pytest.raises(yaml.YAMLError):
        load_untrusted(text)


SCALARS = st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats(allow_nan=False) | st.text()
VALUES = st.recursive(SCALARS, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=20)


@given(VALUES, st.sampled_from([None, False, True]))
@settings(max_examples=50)
def test_what_pyyaml_writes_is_read_back(value, style):
    assume(depth(value) < 20)
    assert load_untrusted(yaml.safe_dump(value, default_flow_style=style)) == value


def depth(value: Any) -> int:
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return 1 + max(map(depth, inner), default=0)


@given(st.text(alphabet=" \n-:?,[]{}#\"'|>!%@`&*~<=.0123456789abetrunlxoy\\é\ud800", max_size=60))
@settings(max_examples=200)
def test_no_text_raises_but_as_told(text):
    with suppress(yaml.YAMLError):
        load_untrusted(text)


@pytest.mark.parametrize("case", HOSTILE)
def test_a_footprint_with_it_is_none_and_has_a_note(case):
    text = f"local_costmap:\n  local_costmap:\n    ros__parameters:\n      footprint: '[[{HOSTILE[case][0]}, 1]]'\n"
    costmap = parse_nav2_costmap(text.encode())
    assert costmap.footprint is None
    (note,) = [note for note in costmap.notes if "footprint" in note]
    assert "is no list of three points [x, y] or more" in note


@pytest.mark.parametrize(
    "text", ["-0x8000_0000_0000_0000", "18446744073709551615", "0b" + "1" * 64, "1:30", "[[1], {}]"]
)
def test_what_64_bits_hold_is_loaded_as_pyyaml_does(text):
    assert load_untrusted(text) == yaml.safe_load(text)
