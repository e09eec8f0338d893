"""AMCL's yamls in the layouts of Nav2 and of ROS 1: what they mean, and that PyYAML reads what is written."""

from __future__ import annotations

import math

import pytest
import yaml

from mapper.core.errors import MapperError
from mapper.localization import LocalizationConfig, amcl_yaml, read_amcl_yaml
from mapper.localization.amcl_parameters import parse_amcl_yaml

NAV2 = b"""
map_server:
  ros__parameters:
    yaml_filename: "house.yaml"
amcl:
  ros__parameters:
    alpha1: 0.1
    base_frame_id: "base_footprint"
    laser_likelihood_max_dist: 1.5
    laser_model_type: "likelihood_field"
    max_beams: 90
    max_particles: 3000
    robot_model_type: "nav2_amcl::OmniMotionModel"
    initial_pose: {x: 1.0, y: 2.0, z: 0.0, yaw: 0.5}
    recovery_alpha_fast: 0.1
    recovery_alpha_slow: 0.001
"""
ROS1 = b"""
odom_model_type: diff-corrected
odom_alpha3: 0.8
laser_z_hit: 0.9
laser_max_beams: 45
kld_err: 0.05
odom_frame_id: odom
"""


def test_nav2():
    found = parse_amcl_yaml(NAV2)
    assert found.layout == "nav2"
    assert found.ignored == ("base_frame_id", "initial_pose")
    assert found.config == LocalizationConfig(
        alpha1=0.1, laser_likelihood_max_dist=1.5, laser_model_type="likelihood_field", laser_max_beams=90,
        max_particles=3000, robot_model_type="omni", recovery_alpha_fast=0.1, recovery_alpha_slow=0.001, z_short=0.05,
    )  # fmt: skip


def test_nav2_below_a_namespace():
    text = b"/**:\n  robot:\n    amcl:\n      ros__parameters:\n        z_hit: 0.7\n"
    assert parse_amcl_yaml(text).config.z_hit == 0.7


def test_ros1_has_defaults_of_its_own():
    found = parse_amcl_yaml(ROS1)
    config = found.config
    assert (found.layout, found.ignored) == ("ros1", ("odom_frame_id",))
    assert (config.alpha3, config.z_hit, config.laser_max_beams, config.pf_err) == (0.8, 0.9, 45, 0.05)
    assert (config.max_particles, config.resample_interval, config.z_rand) == (5000, 2, 0.05)
    assert config.update_min_a == pytest.approx(math.pi / 6)


@pytest.mark.parametrize("layout", ["nav2", "ros1"])
def test_what_is_written_is_read_again(layout):
    config = LocalizationConfig(
        alpha2=0.07, z_hit=0.8, laser_model_type="beam", laser_max_beams=75, max_particles=4000, pf_err=0.02,
        robot_model_type="omni", laser_likelihood_max_dist=3.0, update_min_d=0.1, sigma_hit=0.1,
    )  # fmt: skip
    text = amcl_yaml(config, layout)
    found = parse_amcl_yaml(text.encode())
    assert (found.config, found.layout) == (config, layout)
    values = yaml.safe_load(text)
    if layout == "nav2":
        assert values["amcl"]["ros__parameters"]["max_beams"] == 75
        assert isinstance(values["amcl"]["ros__parameters"]["max_particles"], int)
        assert values["amcl"]["ros__parameters"]["robot_model_type"] == "nav2_amcl::OmniMotionModel"
    else:
        assert (values["laser_max_beams"], values["kld_err"], values["odom_alpha2"]) == (75, 0.02, 0.07)


@pytest.mark.parametrize("layout", ["nav2", "ros1"])
def test_rows_that_amcl_lacks_come_back_from_the_remarks_and_other_readers_do_not_see_them(layout):
    config = LocalizationConfig(
        annealing_stages=3, global_particles=9000, independent_beams=0, least_effective=0.05, reset_below=0.5,
        selective_resampling=True,
    )  # fmt: skip
    text = amcl_yaml(config, layout)
    assert parse_amcl_yaml(text.encode()).config == config
    values = yaml.safe_load(text)
    values = values["amcl"]["ros__parameters"] if layout == "nav2" else values
    own = {"annealing_stages", "global_particles", "independent_beams", "least_effective", "reset_below"}
    assert own.isdisjoint(values)
    assert ("selective_resampling" in values) is (layout == "ros1")


@pytest.mark.parametrize("text", [NAV2, ROS1])
def test_load_save_load_keeps_what_changes_nothing(text: bytes):
    first = parse_amcl_yaml(text)
    written = amcl_yaml(first.config, first.layout, first.others)
    again = parse_amcl_yaml(written.encode())
    assert again == first
    values = yaml.safe_load(written)
    values = values["amcl"]["ros__parameters"] if first.layout == "nav2" else values
    if first.layout == "nav2":
        assert values["base_frame_id"] == "base_footprint"
        assert values["initial_pose"] == {"x": 1.0, "y": 2.0, "z": 0.0, "yaw": 0.5}
    else:
        assert values["odom_frame_id"] == "odom"


def test_other_names_are_those_that_amcl_has():
    with pytest.raises(MapperError, match="AMCL has no parameter 'laser'"):
        amcl_yaml(LocalizationConfig(), others={"laser": 1})


def test_other_values_are_those_that_a_file_may_have():
    nested: object = 1
    for _ in range(2000):
        nested = [nested]
    with pytest.raises(MapperError, match="scan_topic is nested deeper than 20 levels"):
        amcl_yaml(LocalizationConfig(), others={"scan_topic": nested})
    with pytest.raises(MapperError, match=r"scan_topic must be .* not inf"):
        amcl_yaml(LocalizationConfig(), others={"scan_topic": math.inf})


def test_a_remark_is_checked_as_a_value():
    with pytest.raises(MapperError, match="reset_below"):
        parse_amcl_yaml(b"amcl:\n  ros__parameters:\n    z_hit: 0.5\n    # gridbloom: reset_below: 7\n")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"planner_server: {ros__parameters: {use_sim_time: true}}", "no parameters of AMCL: it has 'planner_server'"),
        (b"amcl:\n  ros__parameters:\n    alpha1: much\n", "alpha1 must be a number, not 'much'"),
        (b"amcl:\n  ros__parameters:\n    max_beams: true\n", "max_beams must be a number"),
        (b"amcl:\n  ros__parameters:\n    alpha1: -1.0\n", "alpha1. must be between 0 and 10"),
        (b"amcl:\n  ros__parameters:\n    alpha1: .nan\n", "alpha1. must be a finite number"),
        (b"amcl:\n  ros__parameters:\n    laser_model_type: sonar\n", "laser_model_type. must be one of"),
        (b"amcl:\n  ros__parameters:\n    robot_model_type: tank\n", "robot_model_type must be one of"),
        (b"amcl:\n  ros__parameters:\n    min_particles: 5000\n", "must be at most max_particles"),
        (
            b"amcl:\n  ros__parameters:\n    # gridbloom: reset_below: 2024-13-45\n    z_hit: 0.5\n",
            "reset_below has a value",
        ),
        (b"amcl:\n  ros__parameters:\n    # gridbloom: reset_below: ...\n    z_hit: 0.5\n", "reset_below has a value"),
        (b"amcl:\n  ros__parameters:\n    initial_pose: {x: .nan}\n", "initial_pose must be .* a finite number"),
        (b"amcl:\n  ros__parameters:\n    scan_topic: 2024-01-01\n", "scan_topic must be .* text"),
        (b"amcl:\n  ros__parameters:\n    scan_topic: !!binary /w==\n", "scan_topic must be .* text"),
        (b"amcl: [1, 2\n", "malformed in line"),
        (b"just words", "no names with values"),
        (b"", "no names with values"),
        (b"amcl: {}", "no parameters of AMCL"),
        (b"a: &x [*x]\n", "'x' is within itself"),
        (b"\xff\xfe\x00", "not UTF-8"),
        (b"[" * 5000, "nested deeper"),
        (b"z_hit: " + b"0" * 1_100_000, "may have at most 1048576 bytes"),
    ],
)
def test_yaml_that_cannot_be_used(text: bytes, said: str):
    with pytest.raises(MapperError, match=said):
        parse_amcl_yaml(text)


def test_a_file_that_is_missing(tmp_path):
    with pytest.raises(MapperError, match="cannot be read"):
        read_amcl_yaml(tmp_path / "nothing.yaml")
