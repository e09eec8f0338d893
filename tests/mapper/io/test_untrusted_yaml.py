"""YAML that PyYAML cannot load, or only slowly, is refused with a sentence by each reader of parameter files."""

from __future__ import annotations

import re

import pytest
import yaml

from mapper.core.errors import MapperError
from mapper.costmap.nav2_parameters import parse_nav2_costmap
from mapper.io.untrusted_yaml import load_untrusted
from mapper.localization.amcl_parameters import parse_amcl_yaml
from mapper.planning.nav2_parameters import parse_nav2_path

HOSTILE = {
    "no boolean": ("!!bool perhaps", "'perhaps' is no bool"),
    "no time": ("!!timestamp soon", "'soon' is no timestamp"),
    "no date": ("2001-99-99", "'2001-99-99' is no timestamp"),
    "an integer of 20,000 bits": ("0x" + "f" * 5000, "more than 64 bits"),
    "an integer to the base of 60": (":".join(["59"] * 20_000), "more than 64 bits"),
    "a float to the base of 60": (":".join(["59"] * 200) + ".5", "is no float"),
    "an alias": ("[&a 1, *a]", "alias"),
    "deep lists": ("[" * 9000, "nested"),
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


@pytest.mark.parametrize("case", HOSTILE)
def test_a_footprint_with_it_is_refused(case):
    text = f"local_costmap:\n  local_costmap:\n    ros__parameters:\n      footprint: '[[{HOSTILE[case][0]}, 1]]'\n"
    with pytest.raises(MapperError, match=r"footprint: .* is no list of points"):
        parse_nav2_costmap(text.encode())


@pytest.mark.parametrize(
    "text", ["-0x8000_0000_0000_0000", "18446744073709551615", "0b" + "1" * 64, "1:30", "[[1], {}]"]
)
def test_what_64_bits_hold_is_loaded_as_pyyaml_does(text):
    assert load_untrusted(text) == yaml.safe_load(text)
