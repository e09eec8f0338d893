"""Answers why a voxel of a map in 3D is as it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.errors import ConfigError
from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.mesh.faces import FaceRule, first_face
from mapper.volume.occupancy.provenance import why_voxel
from mapper.volume.occupancy.volume import centres_of, keys_of
from mapper.volume.placed_scan import PlacedScan
from server.parts.volume.chosen_voxel import ChosenVoxel
from server.parts.volume.message_fields import no_voxel, rounded_place, sent_updates
from server.parts.volume.messages import VoxelCommand, VoxelMessage, VoxelRayCommand
from server.sessions.tick import TickResult
from server.stream.message_parts import CellState
from server.stream.protocol import place_of

if TYPE_CHECKING:
    from server.sessions.hosting import ModelHost


class AskedMap(Protocol):
    """A map whose voxels are asked about."""

    @property
    def volume(self) -> OccupancyVolume:
        """The map."""

    @property
    def config(self) -> VolumeConfig:
        """Its parameters."""

    @property
    def index(self) -> int:
        """Number of scans in it."""

    def placed_scans(self) -> Iterable[PlacedScan]:
        """Return these scans; none where they are not known."""


class VoxelQuestions:
    """Answers about voxels; the one that was asked about last is chosen."""

    def __init__(self, host: ModelHost, chosen: ChosenVoxel) -> None:
        self._host, self._chosen = host, chosen
        self.is_busy = False  #: whether an answer is being computed

    def handle(
        self,
        command: VoxelCommand | VoxelRayCommand,
        now: AskedMap,
        rule: Callable[[], FaceRule],
        result: TickResult,
    ) -> None:
        """Answer about a voxel of the map ``now``.

        ``rule`` returns which faces are drawn. Raises :class:`ConfigError` for a place outside of the lattice.
        """
        if isinstance(command, VoxelCommand):
            self._ask(_key_at(command, now), now, result)
            return
        key = first_face(now.volume, rule(), np.array(command.origin), np.array(command.direction))
        self._ask(None if key is None else np.array(key), now, result)

    def clear(self, resolution: float, result: TickResult) -> None:
        """Choose none."""
        self._chosen.choose(None, 0.0)
        result.slot(no_voxel(resolution))

    def _ask(self, key: Int64Array | None, now: AskedMap, result: TickResult) -> None:
        """Answer why a voxel is as it is; None chooses none."""
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
        centre = centres_of(key[None], config.resolution)[0]
        self._chosen.choose(centre, config.resolution, [(one.is_hit, one.origin, one.ends) for one in updates])
        value = float(now.volume.log_odds_of(key[None])[0])
        known = not math.isnan(value)
        state: CellState = "unknown" if not known else "occupied" if value >= config.log_odds_occupied else "free"
        result.slot(
            VoxelMessage(
                centre=rounded_place(centre),
                size=config.resolution,
                log_odds=value if known else None,
                state=state,
                index=now.index,
                total=len(updates),
                hits=sum(update.is_hit for update in updates),
                updates=sent_updates(updates),
            )
        )


def _key_at(command: VoxelCommand, now: AskedMap) -> Int64Array | None:
    """Return the key of the voxel at the place of a command; None for a command without one."""
    given = place_of(command)
    if given is None:
        return None
    place: Float64Array = np.array(given)
    keys, inside = keys_of(place[None].astype(np.float32), now.config.resolution)
    if not inside[0]:
        raise ConfigError("volume.outside", f"The place {place.tolist()} lies outside of the map's lattice.")
    return np.asarray(keys[0])
