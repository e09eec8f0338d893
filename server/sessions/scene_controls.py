"""The controls of a 3D view's panel, as plain data."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from msgspec import Struct

from mapper.core.parameter import Parameter

Bounds = tuple[float, float, float, float]  #: x_min, y_min, x_max, y_max in metres
Heights = tuple[float, float]  #: z_min, z_max in metres


@dataclass(frozen=True, slots=True)
class ParameterTable:
    """A table of parameters, their values, and the command that sets some of them by ``values={name: value}``.

    ``title`` names the tab; ``open_groups`` are the groups of rows that are initially open.
    """

    title: str
    rows: tuple[Parameter, ...]
    values: Mapping[str, Any]
    command: Callable[..., Struct]
    open_groups: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Choice:
    """A choice between names, and the command that sets it by ``name=name``."""

    label: str
    names: tuple[str, ...]
    current: str
    command: Callable[..., Struct]


@dataclass(frozen=True, slots=True)
class Sight:
    """Position of a robot or its sensor, map metres, and its viewing direction, a unit vector."""

    place: tuple[float, float, float]
    ahead: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class SceneControls:
    """The controls of the panel.

    ``hint`` describes the effect of a click in the scene, "" for none. Titles of ``tables`` and labels of ``choices``
    do not change during a session. ``count`` is the number of scans that "seek" can reach, None if the session cannot
    seek; ``index`` is the number of scans in the map. ``bounds`` is the area that the initial camera shows, None for 20
    m around the origin; ``heights`` are its least and greatest z. ``sight`` is what moving cameras follow, None if
    there is nothing to follow.
    """

    playing: bool
    hint: str = ""
    tables: tuple[ParameterTable, ...] = ()
    choices: tuple[Choice, ...] = ()
    index: int = 0
    count: int | None = None
    can_restart: bool = False
    bounds: Bounds | None = None
    heights: Heights = (0.0, 0.0)
    sight: Sight | None = None
