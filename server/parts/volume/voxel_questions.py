"""Answers that explain the state of a voxel of a 3D map."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from mapper.core.array_types import Float32Array, Float64Array, Int64Array
from mapper.core.errors import ConfigError
from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.mesh.faces import FaceRule, first_face
from mapper.volume.occupancy.provenance import why_voxel
from mapper.volume.occupancy.volume import centres_of, keys_of
from mapper.volume.placed_scan import PlacedScan
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.volume.chosen_voxel import ChosenVoxel
from server.parts.volume.message_fields import no_voxel, rounded_place, sent_updates
from server.parts.volume.messages import VoxelCommand, VoxelMessage, VoxelRayCommand
from server.sessions.drawings import Point
from server.sessions.tick import TickResult
from server.stream.message_parts import CellState, VoxelPoint
from server.stream.protocol import place_of

if TYPE_CHECKING:
    from server.sessions.hosting import ModelHost


class AskedMap(Protocol):
    """A map whose voxels can be queried."""

    @property
    def volume(self) -> OccupancyVolume:
        """The map."""

    @property
    def config(self) -> VolumeConfig:
        """Its parameters."""

    @property
    def index(self) -> int:
        """Number of scans in the map."""

    def placed_scans(self) -> Iterable[PlacedScan]:
        """Return these scans; none if they are unknown."""


class VoxelQuestions:
    """Answers about voxels; the last queried voxel is chosen."""

    def __init__(self, host: ModelHost, chosen: ChosenVoxel, scans: ScanSequence | None = None) -> None:
        """Create the answers. ``scans`` are those of the map, whose points are described as well."""
        self._host, self._chosen, self._scans = host, chosen, scans
        self.is_busy = False  #: whether an answer is being computed

    def handle(
        self,
        command: VoxelCommand | VoxelRayCommand,
        now: AskedMap,
        rule: Callable[[], FaceRule],
        result: TickResult,
    ) -> None:
        """Answer a question about a voxel of the map ``now``.

        ``rule`` returns which faces are drawn. Raises :class:`ConfigError` for a place outside of the lattice.
        """
        if isinstance(command, VoxelCommand):
            place = place_of(command)
            start, away = (np.zeros(3) if place is None else np.array(place)), np.zeros(3)
            self._ask(_key_at(command, now), now, (start, away), result)
            return
        start, away = np.array(command.origin), np.array(command.direction)
        key = first_face(now.volume, rule(), start, away)
        self._ask(None if key is None else np.array(key), now, (start, away), result)

    def clear(self, resolution: float, result: TickResult) -> None:
        """Choose none."""
        self._chosen.choose(None, 0.0)
        result.slot(no_voxel(resolution))

    def _ask(
        self, key: Int64Array | None, now: AskedMap, line: tuple[Float64Array, Float64Array], result: TickResult
    ) -> None:
        """Explain the state of a voxel; None chooses none. ``line`` is the viewpoint (3,) and the direction (3,)."""
        config = now.config
        if key is None:
            self.clear(config.resolution, result)
            return
        self.is_busy = True
        try:
            with self._host.cancellable():
                updates = why_voxel(now.placed_scans(), config, key, self._host.may_continue)
        finally:
            self.is_busy = False
        size = config.resolution
        centre = centres_of(key[None], size)[0]
        self._chosen.choose(centre, size, [(update.is_hit, update.origin, update.ends) for update in updates])
        value = float(now.volume.log_odds_of(key[None])[0])
        known = not math.isnan(value)
        state: CellState = "unknown" if not known else "occupied" if value >= config.log_odds_occupied else "free"
        result.slot(
            VoxelMessage(
                centre=rounded_place(centre),
                size=size,
                log_odds=value if known else None,
                state=state,
                index=now.index,
                total=len(updates),
                hits=sum(update.is_hit for update in updates),
                updates=sent_updates(updates),
                point=None if self._scans is None else point_in(self._scans, now.index, centre, size, line),
            )
        )


def place_met(
    now: AskedMap, rule: FaceRule, line: tuple[Float64Array, Float64Array], scans: ScanSequence | None
) -> tuple[Point, float] | None:
    """Return where a line of sight first meets a drawn voxel of the map ``now``, metres, and the side of that voxel.

    The line starts at a place (3,) and has a direction (3,). With ``scans``, whose points are drawn, the result is the
    point in that voxel nearest to the line, and the side is 0. Returns None if the line meets no voxel.
    """
    start, away = line
    key = first_face(now.volume, rule, start, away)
    if key is None:
        return None
    size = now.config.resolution
    centre = centres_of(np.array([key]), size)[0]
    point = None if scans is None else point_in(scans, now.index, centre, size, line)
    if point is not None:
        return point.place, 0.0
    towards = np.where(away == 0.0, np.nan, away)  # a face parallel to the line is not met
    entered = np.nanmax((centre - 0.5 * size * np.sign(away) - start) / towards)
    return rounded_place(start + max(float(entered), 0.0) * away), size


def point_in(
    scans: ScanSequence, index: int, centre: Float32Array, size: float, line: tuple[Float64Array, Float64Array]
) -> VoxelPoint | None:
    """Return the point of the first ``index`` scans in a voxel that is nearest to a line; None if there is none.

    The line starts at a place (3,) and has a direction (3,), which is 0 for the place alone.
    """
    points = scans.points[: scans.starts[index]]
    inside = np.flatnonzero((np.abs(points - centre) <= 0.5 * size).all(axis=1))
    if not len(inside):
        return None
    start, away = line
    apart = points[inside] - start
    length = float(away @ away)
    if length > 0.0:
        apart = apart - (apart @ away / length)[:, None] * away
    nearest = int(inside[np.argmin((apart * apart).sum(axis=1))])
    values = {name: np.atleast_1d(of_all[nearest]).astype(np.float64).tolist() for name, of_all in scans.fields.items()}
    scan = int(np.searchsorted(scans.starts, nearest, side="right"))
    return VoxelPoint(rounded_place(points[nearest]), scan, values, len(inside))


def _key_at(command: VoxelCommand, now: AskedMap) -> Int64Array | None:
    """Return the key of the voxel at the place of a command; None for a command without one."""
    picked = place_of(command)
    if picked is None:
        return None
    place: Float64Array = np.array(picked)
    keys, inside = keys_of(place[None].astype(np.float32), now.config.resolution)
    if not inside[0]:
        raise ConfigError("volume.outside", f"The place {place.tolist()} lies outside of the map’s lattice.")
    return np.asarray(keys[0])
