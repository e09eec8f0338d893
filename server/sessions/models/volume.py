"""The model of a session that shows a map in 3D: it goes through the scans and answers questions about voxels."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from mapper.core.errors import ConfigError, MapperError, WorkCancelledError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.core.parameter import check_names
from mapper.grid import OccupancyGrid
from mapper.volume import VOLUME_PARAMETERS, Octree, OctreeFile, VolumeConfig, octree_file, project
from mapper.volume.blocks import BLOCK
from mapper.volume.faces import FaceRule
from mapper.volume.replayed import ReplayedVolume
from mapper.volume.scan_sequence import ScanSequence
from server.sessions.drawings import Drawing, Point
from server.sessions.messages import NO_READINGS
from server.sessions.model import Footprint, SessionModel
from server.sessions.models.cloud_terrain import CloudPoints
from server.sessions.models.terrain_view import TerrainView
from server.sessions.models.volume_comparison import VolumeComparison
from server.sessions.models.volume_drawings import VolumeDrawings
from server.sessions.models.volume_look import LOOK_PARAMETERS
from server.sessions.models.volume_messages import look_table, volume_message, voxel_message
from server.sessions.models.volume_start import bounds_of, first_look, first_resolution, times_of
from server.sessions.models.voxel_questions import VoxelQuestions
from server.sessions.playback import Playback
from server.sessions.scene_controls import SceneControls
from server.sessions.tick import TickResult
from server.stream.layers import GridLayer, Layer
from server.stream.protocol import ProtocolError, integer, values

if TYPE_CHECKING:
    from server.library.volume_pack import VolumeSource
    from server.sessions.hosting import ModelHost

SLICE_S = 0.1  #: of inserting scans, after which the map is shown as it is
PIECE_S = 0.05  #: of drawing voxels
FILL_S = 20.0  #: in which a sequence plays at first
MOST_SCAN_BOX = 1 << 31  #: voxels of the box around one scan: 200 × 200 × 50 m at 10 cm, some seconds
LOG_ODDS = 3.5  #: the range of the map from above


class VolumeModel(SessionModel):
    """A map of occupied and free voxels of the scans of ``source`` so far, or an octree."""

    kind: ClassVar[str] = "volume"
    replacing: ClassVar[frozenset[str]] = frozenset({"seek", "step", "restart", "parameters"})
    resent_on_refusal: ClassVar[Mapping[str, str]] = {"parameters": "parameters", "volume_look": "volume"}

    def __init__(
        self, host: ModelHost, source: VolumeSource, *, log_id: str, title: str, topic: str | None = None,
        other: tuple[str, VolumeSource] | None = None,
    ) -> None:  # fmt: skip
        """``other`` is the title and the source of a map to compare with."""
        self._host, self._source = host, source
        self._log_id, self._title, self._topic = log_id, title, topic
        self._low, self._high = bounds_of(source)
        self._times = times_of(source)
        self._config = VolumeConfig(resolution=first_resolution(source, self._low, self._high))
        self._map = ReplayedVolume(source, self._config, self._limits)
        self._look = self._first_look = first_look(self._low, self._high, self._config.resolution)
        self.volume = self
        self._drawn = VolumeDrawings(source, self._low, self._high)
        self._questions = VoxelQuestions(host, self._drawn)
        self._target = self._map.count if self._map.count == 1 else 0
        self._layer = GridLayer("map", "Map from above")
        self._stale_grid = True
        self._nodes: int | None = None
        self._comparison = VolumeComparison(other, self._limits)
        points = CloudPoints(source if isinstance(source, ScanSequence) else None, self._low, self._high, other)
        self._terrain = TerrainView(points, points.first, host)
        duration = float(self._times[-1])
        speeds = (0.1, max(100.0, duration / 5.0))
        super().__init__(
            Playback(self._map.count > 1, float(np.clip(float(f"{duration / FILL_S:.2g}"), *speeds)), speeds)
        )
        self._time = 0.0

    def _limits(self) -> Limits:
        """Return the limits of the map: a visitor's cells are voxels here."""
        blocks = max(64, self._host.limits().max_cells // BLOCK**3)
        return replace(DEFAULT_LIMITS, max_blocks=min(DEFAULT_LIMITS.max_blocks, blocks), max_scan_box=MOST_SCAN_BOX)

    # -- what is shown --------------------------------------------------------------------------------------------

    @property
    def layers(self) -> Sequence[Layer]:
        """The map from above, and the terrain while it is on."""
        return (self._layer, *self._terrain.layers)

    @property
    def title(self) -> str:
        """The name of the file."""
        return self._title

    @property
    def grid(self) -> OccupancyGrid | None:
        """The map from above, of the band of heights."""
        try:
            return project(self._map.volume, self._look.band_low, self._look.band_high)
        except MapperError:
            return None

    def octree_bytes(self, kind: str) -> bytes:
        """Return the present map as a file ``.bt`` or ``.ot``; that of an octree of this kind as it was read."""
        if isinstance(self._source, OctreeFile) and self._source.kind == kind:
            return self._source.bytes(self._config)
        return octree_file(Octree.of(self._map.volume), kind, self._config).bytes(self._config)

    @property
    def footprint(self) -> Footprint:
        """The voxels of the map, of the one that it is compared with, and the points."""
        points = 3 * len(self._source.points) if isinstance(self._source, ScanSequence) else self._source.tree.n_nodes
        return Footprint(self._map.n_cells + self._comparison.n_cells + points + self._terrain.cells)

    @property
    def progress(self) -> tuple[int, int]:
        """Scans in the map, scans in total."""
        return (self._map.index, self._map.count)

    def particulars(self) -> dict[str, Any]:
        """Return the file as a log without planar scans, and the table of the map's parameters."""
        scans = self._source if isinstance(self._source, ScanSequence) else None
        rows = [] if scans is None else [asdict(row) for row in VOLUME_PARAMETERS]
        return {
            "map3d": self._terrain.table if rows else [],
            "parameters": {"table": rows, "values": asdict(self._config) if rows else {}},
            "log": {
                "id": self._log_id,
                "topic": self._topic or "",
                "cut": None,
                "trajectory": "",
                "trajectories": [],
                "n_beams": 0,
                "n_scans": self._map.count,
                "duration_s": 0.0 if scans is None or not scans.stamps_ns.any() else float(self._times[-1]),
                "format": f"OctoMap {self._source.kind}" if isinstance(self._source, OctreeFile) else self._source.kind,
                "notes": [] if scans is None else list(scans.notes),
            },
        }

    def messages(self) -> list[dict[str, Any]]:
        """Return what the map has, its parameters, and that no voxel is chosen."""
        return [
            self._message(),
            self._parameters(),
            self._terrain.message(),
            voxel_message(None, self._config.resolution),
        ]

    def _parameters(self) -> dict[str, Any]:
        return {"type": "parameters", "values": asdict(self._config), "sensor": None}

    def frame(self) -> dict[str, Any]:
        """Return the time of the newest scan."""
        return {"stamp": round(float(self._times[max(self._map.index - 1, 0)]), 3)}

    def scan(self) -> dict[str, Any]:
        """Return a scan without readings."""
        return NO_READINGS

    def drawings(self) -> list[Drawing]:
        """Return the voxels, the points, the chosen voxel, and what differs from another map."""
        return self._drawn.current(self._map.volume, self._look)

    def controls(self) -> SceneControls:
        """Return what the camera shows at first."""
        x0, y0, x1, y1 = (float(v) for v in (self._low[0], self._low[1], self._high[0], self._high[1]))
        heights = float(self._low[2]), float(self._high[2])
        return SceneControls(playing=self.playback.playing, bounds=(x0, y0, x1, y1), heights=heights)

    def on_scene_ray(self, origin: Point, direction: Point) -> dict[str, Any] | None:
        """Ask about the voxel that is clicked."""
        return {"type": "voxel_ray", "origin": list(origin), "direction": list(direction)}

    @property
    def _has_free(self) -> bool:
        return not isinstance(self._source, ScanSequence) or self._source.has_origins

    def _rule(self) -> FaceRule:
        return self._drawn.rule(self._map.volume, self._look, has_free=self._has_free)

    def _message(self) -> dict[str, Any]:
        more = {
            "look": look_table(self._first_look, self._look, self._low, self._high),
            "has_free": self._has_free,
            "nodes": self._nodes,
            "compared": self._comparison.fields(),
        }
        return volume_message(self._map, self._drawn, self._low, self._high, more)

    # -- commands -------------------------------------------------------------------------------------------------

    def obey(self, command: dict[str, Any], result: TickResult) -> None:
        """Carry out a command."""
        if self._questions.obey(command, self._map, self._rule, result):
            result.changed = True
            return
        match command["type"]:
            case "terrain":
                self._terrain.obey(command, result)
            case "seek":
                index = integer(command, "index")
                if not 0 <= index <= self._map.count:
                    message = f"There are {self._map.count} scans; there is none after {index}."
                    raise ProtocolError("command.index", message)
                self._go_to(index)
            case "step":
                self.playback.playing = False
                self._go_to(self._map.index + integer(command, "scans", 1))
            case "restart":
                self._go_to(0)
                self.playback.playing = True
            case "cancel":
                self._go_to(self._map.index)
            case "parameters":
                self._set_config(values(command), result)
            case "volume_look":
                self._set_look(values(command))
            case "volume_keep":
                self._comparison.end()
                self._drawn.show_changes(None, self._config.resolution)
                if command.get("value", True) is True:
                    self._comparison.keep(self._map)
                result.slot(self._message())
            case other:
                raise ProtocolError("command.unknown", f"A session in 3D has no command {other!r:.80}.")
        result.changed = True

    def play(self) -> None:
        """Play; from the start if the end was reached."""
        if self._map.index == self._map.count:
            self._go_to(0)
        super().play()

    def _go_to(self, index: int) -> None:
        self._target = min(max(index, 0), self._map.count)
        self._time = float(self._times[max(self._target - 1, 0)]) if self._target else 0.0

    def _set_config(self, wanted: dict[str, Any], result: TickResult) -> None:
        check_names(wanted, VOLUME_PARAMETERS)
        if isinstance(self._source, OctreeFile):
            raise ConfigError("volume.octree", "An octree has no parameters: its scans are not known.")
        config = replace(self._config, **wanted)
        if config == self._config:
            return
        sides = np.maximum((self._high - self._low).astype(np.float64) / config.resolution, 1.0)
        reach = float(np.abs(np.stack([self._low, self._high])).max())
        if reach > (1 << 15) * config.resolution or float(sides.max()) > 1 << 16:
            raise ConfigError(
                "volume.resolution",
                f"At {config.resolution:g} m a voxel the map reaches {32768 * config.resolution:.4g} m from 0 along "
                f"each axis, and the points lie up to {reach:.4g} m from 0; choose a coarser one.",
            )
        self._config = config
        self._map = ReplayedVolume(self._source, config, self._limits)
        self._comparison.note_change()
        self._drawn.faces.clear()
        self._drawn.show_changes(None, config.resolution)
        self._questions.clear(config.resolution, result)
        result.slot(self._parameters())

    def _set_look(self, wanted: dict[str, Any]) -> None:
        check_names(wanted, LOOK_PARAMETERS)
        old, self._look = self._look, replace(self._look, **wanted)
        if (old.band_low, old.band_high) != (self._look.band_low, self._look.band_high):
            self._stale_grid = True
        drawn = ("show", "colour", "band", "whole", "cut_low", "cut_high")
        if any(getattr(old, name) != getattr(self._look, name) for name in drawn):
            self._drawn.note_look(self._map.volume, old, self._look)

    # -- computing ------------------------------------------------------------------------------------------------

    @property
    def is_catching_up(self) -> bool:
        """Whether scans are still to be put into the map."""
        return self._map.index != self._target

    @property
    def fraction(self) -> float | None:
        """The share of the wanted scans that is in the map, or of the terrain that is done."""
        if self._terrain.share is not None:
            return self._terrain.share
        return self._map.index / self._target if self._target and self.is_catching_up else None

    def draw(self, result: TickResult) -> None:
        """Assess the terrain if it has to be."""
        self._terrain.draw(result)

    def advance(self, dt: float, result: TickResult) -> None:
        """Play, and put scans into the map for a tenth of a second."""
        if dt > 0.0 and self.playback.playing:
            self._time = min(self._time + dt * self.playback.speed, float(self._times[-1]))
            self._target = max(self._target, int(np.searchsorted(self._times, self._time, side="right")))
            result.changed = True
        if self.is_catching_up:
            self._catch_up(result)
        if self.playback.playing and self._map.index == self._map.count:
            self.playback.playing = False
            result.changed = True

    def _catch_up(self, result: TickResult) -> None:
        began = time.monotonic()
        self._nodes = None
        try:
            with self._host.cancellable():
                self._map.go_to(self._target, lambda: time.monotonic() - began > SLICE_S, self._host.may_continue)
        except WorkCancelledError:
            raise
        except MapperError:
            self._target = self._map.index
            self._note_change()
            raise
        self._note_change()
        self._drawn.show_newest(self._map.index, self._look)
        result.changed = True

    def _note_change(self) -> None:
        self._drawn.note_change(self._map.volume, self._map.take_touched())
        self._stale_grid = True
        self._comparison.note_change()

    @property
    def has_deferred_work(self) -> bool:
        """Whether voxels, the map from above or the comparison are out of date."""
        return self._drawn.is_stale or self._stale_grid or self._comparison.is_stale or self._nodes is None

    def run_deferred_work(self, result: TickResult) -> None:
        """Bring one of them up to date, or a part of it."""
        began = time.monotonic()
        if self._drawn.is_stale:
            self._drawn.work(
                self._map.volume, self._map.index, self._look, has_free=self._has_free,
                is_over=lambda: time.monotonic() - began > PIECE_S,
            )  # fmt: skip
        elif self._stale_grid:
            self._update_layer()
        elif self._comparison.is_stale:
            self._update_changes(result)
        else:
            self._nodes = Octree.of(self._map.volume).n_nodes
        result.changed = True
        result.slot(self._message())

    def _update_layer(self) -> None:
        self._stale_grid = False
        grid = self.grid
        if grid is not None:
            self._layer.set(grid.geometry, grid.log_odds, -LOG_ODDS, LOG_ODDS, ~grid.observed)

    def _update_changes(self, result: TickResult) -> None:
        try:
            if self._comparison.work(self._map, self._host.may_continue):
                self._drawn.show_changes(self._comparison.changes, self._config.resolution)
        except WorkCancelledError:
            return
        except MapperError as error:
            self._comparison.end()
            result.notice(error.code, error.message)
