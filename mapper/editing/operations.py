"""Operations of a map editor, as values and as JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any, ClassVar, TypeAlias

from mapper.core.errors import ConfigError

MAX_POINTS = 20_000  #: per operation
MAX_WIDTH = 20.0  #: m, of a brush
MAX_SPECK = 10_000  #: cells
FARTHEST = 1e6  #: m
VALUES = {"free": 0, "occupied": 100, "unknown": -1}  #: of nav_msgs/OccupancyGrid, by the painted state

Points: TypeAlias = "tuple[tuple[float, float], ...]"


def _number(value: object, what: str, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ConfigError("edit.value", f"{what} must be a number, {low:g} … {high:g}, not {value!r:.40}.")
    return float(value)


def _points(value: object, what: str, least: int) -> Points:
    if not isinstance(value, list | tuple) or not least <= len(value) <= MAX_POINTS:
        n = len(value) if isinstance(value, list | tuple) else "none"
        raise ConfigError("edit.points", f"{what} must have {least} to {MAX_POINTS} points [x, y], not {n}.")
    points = []
    for k, point in enumerate(value):
        if not isinstance(point, list | tuple) or len(point) != 2:
            raise ConfigError("edit.points", f"{what}: point {k} must be [x, y] in m, not {point!r:.40}.")
        x, y = (_number(part, f"{what}: a coordinate of point {k}", -FARTHEST, FARTHEST) for part in point)
        points.append((x, y))
    return tuple(points)


def _state(value: object) -> str:
    if value not in VALUES:
        raise ConfigError("edit.state", f"The painted state must be one of {', '.join(VALUES)}, not {value!r:.40}.")
    return str(value)


@dataclass(frozen=True, slots=True)
class Paint:
    """A stroke: cells with centres within ``width`` / 2 (m) of the line through ``points``, or containing a point.

    ``state`` is free, occupied or unknown. The cells that contain a point are painted even with a very narrow brush.
    """

    op: ClassVar[str] = "paint"
    state: str
    width: float
    points: Points

    @property
    def phrase(self) -> str:
        """Description of the edit, for a list of edits."""
        return f"Painted {self.state}, {self.width:g} m wide"

    def __post_init__(self) -> None:
        object.__setattr__(self, "state", _state(self.state))
        object.__setattr__(self, "width", _number(self.width, "The brush’s width", 0.0, MAX_WIDTH))
        object.__setattr__(self, "points", _points(self.points, "A stroke", 1))


@dataclass(frozen=True, slots=True)
class Fill:
    """Set cells with centres in a polygon to free, occupied or unknown."""

    op: ClassVar[str] = "fill"
    state: str
    polygon: Points

    @property
    def phrase(self) -> str:
        """Description of the edit, for a list of edits."""
        return f"Filled an area: {self.state}"

    def __post_init__(self) -> None:
        object.__setattr__(self, "state", _state(self.state))
        object.__setattr__(self, "polygon", _points(self.polygon, "An area", 3))


@dataclass(frozen=True, slots=True)
class Keepout:
    """Set a ``value`` of the keepout mask in cells with centres in a polygon: 1 … 100, 0 for none."""

    op: ClassVar[str] = "keepout"
    polygon: Points
    value: float = 100

    @property
    def phrase(self) -> str:
        """Description of the edit, for a list of edits."""
        return "Marked a keepout zone" if self.value else "Erased a keepout zone"

    def __post_init__(self) -> None:
        object.__setattr__(self, "polygon", _points(self.polygon, "A keepout zone", 3))
        object.__setattr__(self, "value", _number(self.value, "A keepout zone’s value", 0, 100))


@dataclass(frozen=True, slots=True)
class Speed:
    """Set a ``value`` of the speed filter's mask in cells with centres in a polygon: 1 … 100, 0 for no limit."""

    op: ClassVar[str] = "speed"
    polygon: Points
    value: float = 50

    @property
    def phrase(self) -> str:
        """Description of the edit, for a list of edits."""
        return f"Set a speed limit: {self.value:g}" if self.value else "Erased a speed limit"

    def __post_init__(self) -> None:
        object.__setattr__(self, "polygon", _points(self.polygon, "A zone with a speed limit", 3))
        object.__setattr__(self, "value", _number(self.value, "A speed limit’s value", 0, 100))


@dataclass(frozen=True, slots=True)
class Despeckle:
    """Set groups of at most ``cells`` occupied cells, connected by sides or corners, to free."""

    op: ClassVar[str] = "despeckle"
    cells: float

    @property
    def phrase(self) -> str:
        """Description of the edit, for a list of edits."""
        return f"Removed specks of up to {self.cells:g} cells"

    def __post_init__(self) -> None:
        object.__setattr__(self, "cells", _number(self.cells, "The size of a speck", 1, MAX_SPECK))


@dataclass(frozen=True, slots=True)
class Rotate:
    """Rotate the map by ``angle`` (rad, counter-clockwise) about the origin of its coordinates.

    The new cells are axis-aligned; each has the value of the old cell that contains its centre.
    """

    op: ClassVar[str] = "rotate"
    angle: float

    @property
    def phrase(self) -> str:
        """Description of the edit, for a list of edits."""
        return f"Turned by {math.degrees(self.angle):.1f}°"

    def __post_init__(self) -> None:
        object.__setattr__(self, "angle", _number(self.angle, "The angle", -math.tau, math.tau))


@dataclass(frozen=True, slots=True)
class Crop:
    """Keep only the cells touched by the rectangle between two corners (m)."""

    op: ClassVar[str] = "crop"
    corners: Points

    @property
    def phrase(self) -> str:
        """Description of the edit, for a list of edits."""
        return "Cropped"

    def __post_init__(self) -> None:
        object.__setattr__(self, "corners", _points(self.corners, "A crop", 2))
        if len(self.corners) != 2:
            raise ConfigError("edit.points", f"A crop needs two corners, not {len(self.corners)}.")


@dataclass(frozen=True, slots=True)
class Origin:
    """Move the pose (``x``, ``y``, ``yaw``) of the map to (0, 0, 0); cells keep their values."""

    op: ClassVar[str] = "origin"
    x: float
    y: float
    yaw: float = 0.0

    @property
    def phrase(self) -> str:
        """Description of the edit, for a list of edits."""
        return f"Moved the origin to ({self.x:.2f}, {self.y:.2f})"

    def __post_init__(self) -> None:
        for name, most in (("x", FARTHEST), ("y", FARTHEST), ("yaw", math.tau)):
            object.__setattr__(self, name, _number(getattr(self, name), f"The origin’s {name}", -most, most))


Operation: TypeAlias = Paint | Fill | Keepout | Speed | Despeckle | Rotate | Crop | Origin
_KINDS: Mapping[str, type[Operation]] = {
    kind.op: kind for kind in (Paint, Fill, Keepout, Speed, Despeckle, Rotate, Crop, Origin)
}


def parse_operation(entry: object) -> Operation:
    """Return an operation from a mapping with its name ``op`` and its fields. Raises :class:`ConfigError`."""
    if not isinstance(entry, Mapping) or entry.get("op") not in _KINDS:
        op = entry.get("op") if isinstance(entry, Mapping) else entry
        raise ConfigError("edit.op", f"An edit’s 'op' must be one of {', '.join(_KINDS)}, not {op!r:.40}.")
    kind = _KINDS[entry["op"]]
    names = [field.name for field in fields(kind)]
    for name in entry:
        if name != "op" and name not in names:
            raise ConfigError("edit.field", f"The edit {kind.op!r} has no {name!r:.40}: it has {', '.join(names)}.")
    try:
        return kind(**{name: value for name, value in entry.items() if name != "op"})
    except TypeError as error:
        missing = [name for name in names if name not in entry]
        raise ConfigError("edit.field", f"The edit {kind.op!r} lacks {', '.join(missing)}.") from error


def operation_dict(operation: Operation) -> dict[str, Any]:
    """Return an operation as a mapping that :func:`parse_operation` reads."""
    return {"op": operation.op, **asdict(operation)}
