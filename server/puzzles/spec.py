"""Definition of a visitor's puzzle, stored as JSON: a history of the lab or a log, and the fault."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, TypeAlias

import msgspec
from msgspec import Struct, field

from mapper.core.errors import ConfigError
from mapper.core.parameter import Values
from mapper.mapping.parameters import CONES
from mapper.puzzles import CAUSES
from server.sessions.view import LogView
from server.sources.history import SimulationHistory

AS_IT_IS = "as-it-is"  #: the fault that the session's parameters, or the robot, currently have
COARSE, WIDE = 0.1, 0.4  #: metres: larger cells and windows are a fault


class WorldSpec(Struct, frozen=True, tag_field="kind", tag="story"):
    """A puzzle of a simulated world: its history, the requested ``fault``, its ``cause``, and the seed of its size."""

    history: SimulationHistory = field(name="story")
    fault: str
    cause: str
    seed: int


class SensorView(Struct, frozen=True):
    """The sensor and the poses of a log, as in :class:`server.sessions.view.LogView`."""

    topic: str | None
    trajectory: str | None
    cut: dict[str, float] | None


class LogSpec(Struct, frozen=True, tag_field="kind", tag="log"):
    """A puzzle of a log: its view, the parameters that differ from the initial ones, and the fault."""

    view: SensorView
    values: Values
    fault: str
    cause: str
    seed: int


Spec: TypeAlias = WorldSpec | LogSpec


def spec_text(spec: Spec) -> str:
    """Return a spec as stored text."""
    return json.dumps(msgspec.to_builtins(spec, enc_hook=SimulationHistory.model_dump))


def spec_from_text(text: str) -> Spec:
    """Return the spec from which :func:`spec_text` produced ``text``.

    Raises ``msgspec.DecodeError`` for anything else, and :class:`ConfigError` for an unknown command.
    """
    spec: Spec = msgspec.json.decode(text, type=Spec, dec_hook=lambda _, story: SimulationHistory.model_validate(story))
    return spec


def cause_of(values: Mapping[str, Any], faults: Mapping[str, Any], *, cone: bool = False) -> str:
    """Return the fault of a map made with these ``values`` that differ from the initial ones.

    ``faults`` are those of a simulated robot. Raises :class:`ConfigError` if there is no fault.
    """
    cause = {
        "drift": faults.get("drift") and not faults.get("slam"),
        "polished": faults.get("specular"),
        "beam_order": values.get("mount_upside_down"),
        "mount_yaw": values.get("mount_yaw"),
        "mount_x": values.get("mount_x") or values.get("mount_y"),
        "time_offset": values.get("time_offset"),
        "max_range": values.get("no_return") == "hit",
        "resolution": values.get("resolution", 0.0) > COARSE,
        "window": values.get("window", 0.0) > WIDE,
        "sonar": cone and values.get("model", CONES[0]) not in CONES,
        "sweep": values.get("deskew") == "off",
        "clamp": values.get("clamp") is False,
    }
    for name, is_there in cause.items():
        if is_there:
            return name
    raise ConfigError("puzzle.nothing_wrong", "This map has no fault that a puzzle could ask for: choose one.")


def _checked(cause: str) -> str:
    if cause == AS_IT_IS or (cause in CAUSES and CAUSES[cause].of_log):
        return cause
    raise ConfigError("puzzle.cause", f"No log or world can be given the fault {cause!r:.80}.")


def spec_of_world(history: SimulationHistory, cause: str, seed: int, *, cone: bool) -> WorldSpec:
    """Return the spec of a puzzle of a simulated world. Raises like :func:`cause_of`, and for an impossible fault.

    A world of which only the pose is known, and not the drive, is rejected.
    """
    kind = _checked(cause)
    if history.journal is None:
        raise ConfigError("puzzle.story", "The history of this world is too long to be repeated: press Reset first.")
    named = cause_of(history.parameters, history.faults, cone=cone) if kind == AS_IT_IS else kind
    return WorldSpec(history, kind, named, seed)


def spec_of_log(view: LogView, values: Values, cause: str, seed: int, *, cone: bool) -> LogSpec:
    """Return the spec of a puzzle of a log: ``view`` has its sensor and poses, ``values`` the changed parameters."""
    kind = _checked(cause)
    named = cause_of(values, {}, cone=cone) if kind == AS_IT_IS else kind
    return LogSpec(SensorView(view.topic, view.trajectory, view.cut), values, kind, named, seed)
