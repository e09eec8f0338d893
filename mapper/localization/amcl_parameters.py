"""AMCL parameters as yaml, in Nav2's layout (``amcl: ros__parameters:``) and that of ROS 1 (plain names).

Only plain scalars are used. Source: the documentation of nav2_amcl (docs.nav2.org) and of amcl (wiki.ros.org/amcl), for
names and defaults.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

import yaml

from mapper.core.errors import ConfigError, ReadError
from mapper.io.nav2_declared import AMCL, NODE, undeclared, within, wrong_type
from mapper.io.ros_parameters import MAX_DEPTH, find_node, parse_ros_parameters, read_parameter_file, value_below
from mapper.io.untrusted_yaml import load_untrusted
from mapper.localization.parameters import BY_NAME, LocalizationConfig

Layout = Literal["nav2", "ros1"]

#: Nav2's names of rows that are named differently here.
NAV2_NAMES = {"max_beams": "laser_max_beams", "laser_likihood_max_dist": "laser_likelihood_max_dist"}
_ROS1_NAMES = {
    **{f"odom_alpha{k}": f"alpha{k}" for k in range(1, 6)},
    **{f"laser_{name}": name for name in ("z_hit", "z_short", "z_max", "z_rand", "sigma_hit", "lambda_short")},
    "kld_err": "pf_err",
    "kld_z": "pf_z",
    "odom_model_type": "robot_model_type",
}
#: Defaults of ROS 1's AMCL that differ from Nav2's.
ROS1_DEFAULTS: Mapping[str, Any] = {
    "laser_model_type": "likelihood_field", "laser_max_beams": 30, "laser_max_range": -1.0, "z_hit": 0.95,
    "z_short": 0.1, "z_rand": 0.05, "update_min_d": 0.2, "update_min_a": math.pi / 6.0, "min_particles": 100,
    "max_particles": 5000, "pf_err": 0.01, "resample_interval": 2,
}  # fmt: skip
_MODELS = {
    "nav2_amcl::DifferentialMotionModel": "differential", "nav2_amcl::OmniMotionModel": "omni",
    "differential": "differential", "omnidirectional": "omni",
    "diff": "differential", "diff-corrected": "differential", "omni": "omni", "omni-corrected": "omni",
}  # fmt: skip
#: Defaults of Nav2 (amcl_node.cpp) that differ from this project's.
NAV2_DEFAULTS: Mapping[str, Any] = {"laser_model_type": "likelihood_field", "z_short": 0.05}
#: Rows that Nav2's AMCL lacks; ROS 1's has selective_resampling.
OWN_ROWS = (
    "annealing_stages", "global_particles", "independent_beams", "least_effective", "reset_below",
    "selective_resampling",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class AmclParameters:
    """Contents of an AMCL yaml: the parameters, the layout, and keys that do not affect the estimate.

    ``others`` are the values of those keys by name, which :func:`amcl_yaml` writes again. ``notes`` are sentences on
    names that AMCL does not declare.
    """

    config: LocalizationConfig
    layout: Layout
    others: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def ignored(self) -> tuple[str, ...]:
        """The names of the others."""
        return tuple(self.others)


def read_amcl_yaml(path: str | os.PathLike[str]) -> AmclParameters:
    """Return the parameters in an AMCL yaml. Raises the errors of :func:`parse_amcl_yaml`, and for an unreadable
    file.
    """
    return parse_amcl_yaml(read_parameter_file(path))


def parse_amcl_yaml(data: bytes) -> AmclParameters:
    """Return the parameters in the text of an AMCL yaml; the node may be anywhere in a Nav2 file.

    Missing values are AMCL's defaults, those of ROS 1 for its layout. Rows that AMCL lacks are read from the comments
    written by :func:`amcl_yaml`. Raises :class:`ReadError` for text that is not such a yaml and for an invalid value,
    :class:`ConfigError` for an impossible value, and the errors of
    :func:`mapper.io.ros_parameters.parse_ros_parameters`.
    """
    root = parse_ros_parameters(data)
    values, layout = _node(root)
    names = NAV2_NAMES if layout == "nav2" else _ROS1_NAMES
    parameters: dict[str, Any] = {}
    others = {}
    notes = [*root.notes]
    for name, value in (values | _remarks(data)).items():
        own = names.get(name, name)
        if own in BY_NAME:
            parameters[own] = _value(name, own, value)
            if own not in OWN_ROWS:
                if layout == "nav2" and BY_NAME[own].kind == "number":
                    notes += wrong_type(value, f"amcl.{name}", is_whole=_is_whole(own))
                parameters[own] = within(BY_NAME[own], parameters[own], f"amcl.{name}", notes)
        elif is_other(name):
            others[name] = _checked_other(name, value)
        else:
            notes.append(undeclared("amcl", name, {*AMCL, *BY_NAME, *names}))
    start = LocalizationConfig().with_values(NAV2_DEFAULTS if layout == "nav2" else ROS1_DEFAULTS)
    return AmclParameters(start.with_values(parameters), layout, others, tuple(notes))


def is_other(name: str) -> bool:
    """Return whether AMCL has a parameter of that name that does not affect the estimate."""
    return name.partition(".")[0] in AMCL | NODE


def _checked_other(name: str, value: object, depth: int = 0) -> object:
    """Return a value that yaml and JSON can represent. Raises :class:`ConfigError` for others, such as a date."""
    if depth > MAX_DEPTH:
        raise ConfigError("amcl.value", f"{name:.80} is nested deeper than {MAX_DEPTH} levels.")
    if isinstance(value, list):
        return [_checked_other(name, item, depth + 1) for item in value]
    if isinstance(value, dict):
        return {str(key): _checked_other(name, item, depth + 1) for key, item in value.items()}
    if value is None or isinstance(value, bool | int | str) or (isinstance(value, float) and math.isfinite(value)):
        return value
    raise ConfigError("amcl.value", f"{name:.80} must be true or false, a finite number or text, not {value!r:.80}.")


def _remarks(data: bytes) -> dict[str, Any]:
    """Return the values of rows that AMCL lacks, from the comments at the end of a yaml of :func:`amcl_yaml`.

    Raises :class:`ReadError` for a value that is not yaml.
    """
    remarks = re.findall(rb"^\s*# gridbloom: (\w+): ([\w.+-]+)\s*$", data, re.MULTILINE)
    values = {}
    for name, text in ((name.decode(), value.decode()) for name, value in remarks):
        if name in OWN_ROWS:
            try:
                values[name] = load_untrusted(text)
            except yaml.YAMLError as error:
                raise ReadError("amcl.value", f"{name} has a value that cannot be read: {text:.80}.") from error
    return values


def _node(root: dict[str, Any]) -> tuple[dict[str, Any], Layout]:
    """Return AMCL's parameters: from ``amcl: ros__parameters:`` anywhere, from ``amcl:``, or the top-level keys."""
    node = find_node(root, ("amcl",), {*BY_NAME, *NAV2_NAMES, *AMCL} - {"transform_tolerance", "map_topic"})
    if node is not None:
        return _named(node[1]), "nav2"
    named = value_below(root, "amcl")
    top = named if isinstance(named, dict) else root
    if isinstance(top.get("ros__parameters"), dict):
        return _named(top["ros__parameters"]), "nav2"
    if not top:
        raise ReadError("amcl.yaml", "The yaml has no parameters of AMCL: no 'amcl' with 'ros__parameters', no names.")
    values = _named(top)
    if top is root and not values.keys() & {*AMCL, *BY_NAME, *NAV2_NAMES, *_ROS1_NAMES}:
        has = ", ".join(map(repr, values))
        raise ReadError("amcl.yaml", f"The yaml has no parameters of AMCL: it has {has:.80}.")
    is_ros1 = any(name in _ROS1_NAMES or name == "laser_max_beams" for name in values)
    return values, "ros1" if is_ros1 else "nav2"


def _named(node: dict[Any, Any]) -> dict[str, Any]:
    return {str(name).removeprefix("~"): value for name, value in node.items()}


def _value(name: str, own: str, value: object) -> object:
    row = BY_NAME[own]
    if own == "robot_model_type":
        if value not in _MODELS:
            raise ConfigError("amcl.value", f"{name} must be one of {', '.join(_MODELS)}, not {value!r:.80}.")
        return _MODELS[str(value)]
    if row.kind == "number" and (isinstance(value, bool) or not isinstance(value, int | float)):
        raise ConfigError("amcl.value", f"{name} must be a number, not {value!r:.80}.")
    return value


def amcl_yaml(config: LocalizationConfig, layout: Layout = "nav2", others: Mapping[str, Any] | None = None) -> str:
    """Return the parameters as an AMCL yaml, with the ``others`` of the yaml from which they were read.

    Rows that AMCL lacks are comments at the end. Raises :class:`ConfigError` for another name that AMCL does not have,
    and for a value of the others that a parameter file cannot represent.
    """
    unknown = [name for name in others or {} if not is_other(name)]
    if unknown:
        raise ConfigError("amcl.unknown", f"AMCL has no parameter {unknown[0]!r:.80}.")
    names = {own: name for name, own in (NAV2_NAMES if layout == "nav2" else _ROS1_NAMES).items()}
    names["laser_likelihood_max_dist"] = "laser_likelihood_max_dist"
    own_rows = OWN_ROWS if layout == "nav2" else tuple(name for name in OWN_ROWS if name != "selective_resampling")
    lines: list[str] = []
    remarks: list[str] = []
    for name, value in asdict(config).items():
        text = _text(name, value, layout)
        (remarks if name in own_rows else lines).append(f"{names.get(name, name)}: {text}")
    for name, value in (others or {}).items():
        written = yaml.safe_dump({name: _checked_other(name, value)}, default_flow_style=False)
        lines.extend(written.rstrip("\n").split("\n"))
    if layout == "ros1":
        return "".join(f"{line}\n" for line in lines) + "".join(f"# gridbloom: {line}\n" for line in remarks)
    return (
        "amcl:\n  ros__parameters:\n"
        + "".join(f"    {line}\n" for line in lines)
        + "".join(f"    # gridbloom: {line}\n" for line in remarks)
    )


def _text(name: str, value: object, layout: Layout) -> str:
    if name == "robot_model_type":
        nav2 = {"differential": '"nav2_amcl::DifferentialMotionModel"', "omni": '"nav2_amcl::OmniMotionModel"'}
        ros1 = {"differential": '"diff-corrected"', "omni": '"omni-corrected"'}
        return (nav2 if layout == "nav2" else ros1)[str(value)]
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    number = float(str(value))
    return str(int(number)) if _is_whole(name) else repr(number)


def _is_whole(name: str) -> bool:
    """Return whether AMCL declares a number as an integer."""
    return BY_NAME[name].step >= 1.0
