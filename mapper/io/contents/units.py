"""Units of the fields of messages whose names have one by REP 103 and by ROS' own definitions."""

from __future__ import annotations

_AXES = {
    "position": "m", "translation": "m", "linear": "m/s", "angular": "rad/s", "angular_velocity": "rad/s",
    "linear_acceleration": "m/s²", "force": "N", "torque": "N·m",
}  # fmt: skip
_NAMES = {
    "roll": "rad", "pitch": "rad", "yaw": "rad", "voltage": "V", "current": "A", "temperature": "°C",
    "latitude": "°", "longitude": "°", "altitude": "m",
}  # fmt: skip
_RATES = {"": "1/s", "m/s": "m/s²", "rad/s": "rad/s²"}


def unit_of(field: str) -> str:
    """Return the unit of a field, by its path in the message; an empty text where its name has none."""
    rest, _, name = field.rpartition(".")
    return _AXES.get(rest.rpartition(".")[2], "") if name in ("x", "y", "z") else _NAMES.get(name, "")


def unit_of_rate(unit: str) -> str:
    """Return the unit of the change of a number per second."""
    return _RATES.get(unit, f"{unit}/s")
