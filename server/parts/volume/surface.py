"""The surface of a 3D session from truncated signed distances: its parameters, its mesh in chunks, its voxels."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array, Int64Array
from mapper.core.errors import ConfigError
from mapper.core.limits import Limits
from mapper.core.parameter import with_values
from mapper.volume import TsdfConfig, surface_mesh
from mapper.volume.kernels.faces import CHUNK
from mapper.volume.mesh.chunk_mesh import STEPS, ChunkMesh, cut_between
from mapper.volume.mesh.files import glb_bytes, ply_bytes
from mapper.volume.mesh.surface_chunks import ChunkKey, SurfaceChunks
from mapper.volume.occupancy.volume import centres_of, keys_of
from mapper.volume.surface.parameters import TSDF_PARAMETERS
from mapper.volume.surface.questions import first_surface, why_surface
from mapper.volume.surface.replayed import SNAPSHOT_BYTES, MeasuredScans, ReplayedSurface
from mapper.volume.surface.tsdf import CENTRE
from server.parts.volume.look import COLOURS, HEIGHT_RAMP, Corner, Look, normal_colors, ramp_of
from server.parts.volume.message_fields import MOST_UPDATES, rounded_place
from server.parts.volume.messages import SurfaceMessage, SurfaceVoxelMessage, VoxelCommand, VoxelRayCommand
from server.sessions.drawings import Point, Surface
from server.sessions.tick import TickResult
from server.stream.message_parts import SurfaceUpdate as SentUpdate
from server.stream.message_parts import rows_of
from server.stream.protocol import place_of

if TYPE_CHECKING:
    from server.parts.volume.chosen_voxel import ChosenVoxel
    from server.sessions.hosting import ModelHost

MESH_S = 0.05  #: longest time of meshing chunks; the others wait for the next tick
SENDING_S = 0.1  #: pause of other work after a change of the mesh, so that the changed triangles are sent first
MOST_TRIANGLES = 4_000_000  #: maximum number drawn
FINEST_M = 0.02  #: initial voxel size, at least


def height_colors(key: ChunkKey, mesh: ChunkMesh, size: float, low: float, look: Look) -> NDArray[np.uint8]:
    """Return the colours (n, 3) of a chunk's vertices by height; ``low`` is the height of the first colour, metres."""
    heights = (CHUNK * key[2] - CENTRE + 0.5 + mesh.places[:, 2] / STEPS) * size
    return ramp_of(heights, low, low + COLOURS * look.band, HEIGHT_RAMP)


class VolumeSurface:
    """The surface of a sequence of scans, None if there is none. Nothing is computed until it is requested."""

    def __init__(
        self, source: MeasuredScans | None, resolution: float, limits: Callable[[], Limits],
        *, snapshot_bytes: int = SNAPSHOT_BYTES,
    ) -> None:  # fmt: skip
        self._snapshot_bytes = snapshot_bytes
        self._source = source if source is not None and source.has_origins else None
        self._limits = limits
        self.config = TsdfConfig(resolution=max(resolution, FINEST_M))
        self._first = self.config
        self._chunks = SurfaceChunks()
        self._replayed: ReplayedSurface | None = None
        self._sent_at = 0.0  #: when to send the mesh, seconds of :func:`time.monotonic`
        self.is_busy = False  #: whether an answer about a voxel is being computed
        #: For each chunk: its mesh, the box by which it was cut, and the result.
        self._shown: dict[ChunkKey, tuple[ChunkMesh, tuple[Corner, Corner], ChunkMesh | None]] = {}

    @property
    def is_possible(self) -> bool:
        """Whether the poses of the sensor are known."""
        return self._source is not None

    @property
    def replayed(self) -> ReplayedSurface:
        """The surface so far. Raises :class:`ConfigError` if none is possible."""
        if self._source is None:
            raise ConfigError(
                "tsdf.no_origin",
                "A surface needs scans and the positions of the sensor, from which distances are measured.",
            )
        if self._replayed is None:
            self._replayed = ReplayedSurface(
                self._source, self.config, self._limits, snapshot_bytes=self._snapshot_bytes
            )
        return self._replayed

    @property
    def cells(self) -> int:
        """Number of 4-byte values that it uses."""
        if self._replayed is None:
            return 0
        triangles = self._chunks.n_triangles
        return self._replayed.n_cells + 4 * triangles

    @property
    def is_stale(self) -> bool:
        """Whether chunks must be meshed again."""
        return self._chunks.pending > 0

    def set_values(self, values: Mapping[str, Any]) -> bool:
        """Use other parameters; return whether the surface must be recomputed. Raises :class:`ConfigError`."""
        config = with_values(self.config, values)
        self.replayed  # noqa: B018 - raises where there is none
        return self.use(config)

    def use(self, config: TsdfConfig) -> bool:
        """Use other parameters; return whether the surface must be recomputed."""
        if config == self.config:
            return False
        self.config, self._replayed = config, None
        return True

    def set_source(self, source: MeasuredScans) -> None:
        """Compute the surface of other scans, which include the poses of their sensor."""
        self._source, self._replayed = source, None

    def mesh(self) -> None:
        """Mesh what has changed since the last call, or a part of it."""
        began = time.monotonic()
        now = self.replayed
        if (touched := now.take_touched()) is None or len(touched):
            self._chunks.note_change(now.volume, touched)
        self._chunks.work(now.volume, lambda: time.monotonic() - began > MESH_S)
        self._sent_at = time.monotonic() + SENDING_S

    @property
    def sending_s(self) -> float:
        """Remaining seconds for sending the whole mesh; 0 if it is sent, or not complete yet."""
        return 0.0 if self.is_stale else max(self._sent_at - time.monotonic(), 0.0)

    def file(self, kind: str, index: int, offset: Float64Array | None = None) -> bytes:
        """Return the surface of the first ``index`` scans as ``.ply`` or ``.glb``. Raises :class:`ConfigError`.

        ``offset`` is passed to :func:`mapper.volume.mesh.files.ply_bytes`.
        """
        now = self.replayed
        now.go_to(index)
        mesh = surface_mesh(now.volume)
        return (ply_bytes if kind == ".ply" else glb_bytes)(mesh, offset)

    # -- display --------------------------------------------------------------------------------------------------

    @property
    def _problem(self) -> str | None:
        if self._chunks.n_triangles <= MOST_TRIANGLES:
            return None
        return (
            f"The surface has {self._chunks.n_triangles:,} triangles, more than the {MOST_TRIANGLES:,} that are drawn; "
            "choose a coarser resolution."
        )

    def drawing(self, look: Look, low: float) -> Surface:
        """Return the triangles; ``low`` is the height of the first colour, metres."""
        size = self.config.resolution
        by_normal = look.colour == "normal"

        def colors(key: ChunkKey, mesh: ChunkMesh) -> NDArray[np.uint8]:
            if by_normal:
                return normal_colors(mesh.normals)
            return height_colors(key, mesh, size, low, look)

        chunks = {} if self._problem else self._cut(look)
        return Surface(
            name="surface", label="Surface", chunks=chunks, colors=colors, colors_key=(by_normal, look.band, low),
            size=size, corner=CENTRE,
        )  # fmt: skip

    def _cut(self, look: Look) -> dict[ChunkKey, ChunkMesh]:
        """Return the chunks within the clip box; an unchanged one is the same object."""
        box = look.low, look.high
        size = self.config.resolution
        before, self._shown = self._shown, {}
        chunks = {}
        for key, mesh in self._chunks.chunks.items():
            whole, cut_at, cut = before.get(key, (None, None, None))
            if whole is not mesh or cut_at != box:
                first = (CHUNK * np.array(key) - CENTRE + 0.5) * size
                cut = cut_between(mesh, *((corner - first) / size * STEPS for corner in box))
            self._shown[key] = mesh, box, cut
            if cut is not None:
                chunks[key] = cut
        return chunks

    def message(self) -> SurfaceMessage:
        """Return the ``surface`` message."""
        now = self._replayed
        return SurfaceMessage(
            table=rows_of(TSDF_PARAMETERS, self._first) if self.is_possible else [],
            values=asdict(self.config),
            truncation=round(float(self.config.band), 6),
            index=0 if now is None else now.index,
            blocks=0 if now is None else now.volume.blocks.count,
            bytes=0 if now is None else now.volume.n_bytes,
            triangles=self._chunks.n_triangles,
            chunks=len(self._chunks.chunks),
            pending=self._chunks.pending,
            snapshots=[] if now is None else list(now.snapshots),
            problem=self._problem,
        )

    def no_voxel(self) -> SurfaceVoxelMessage:
        """Return the ``surface_voxel`` message for no voxel."""
        return SurfaceVoxelMessage(
            centre=None, size=self.config.resolution, distance=None, weight=0.0, index=0, total=0, updates=[]
        )

    # -- questions ------------------------------------------------------------------------------------------------

    def ask(
        self, command: VoxelCommand | VoxelRayCommand, host: ModelHost, chosen: ChosenVoxel, result: TickResult
    ) -> None:
        """Answer ``voxel`` and ``voxel_ray``: explain the distance of a voxel of the surface."""
        key = self._key_of(command)
        if key is None:
            chosen.choose(None, 0.0)
            result.slot(self.no_voxel())
            return
        now, size = self.replayed, self.config.resolution
        self.is_busy = True
        try:
            with host.cancellable():
                updates = why_surface(now, key, host.may_continue)
        finally:
            self.is_busy = False
        centre = centres_of(key[None], size)[0]
        # If the measured distance is within a voxel, the beam ended there.
        chosen.choose(centre, size, [(abs(update.measured) <= size, update.origin, centre[None]) for update in updates])
        result.slot(
            SurfaceVoxelMessage(
                centre=rounded_place(centre),
                size=size,
                distance=updates[-1].after if updates else None,
                weight=updates[-1].weight if updates else 0.0,
                index=now.index,
                total=len(updates),
                updates=[
                    SentUpdate(
                        scan=update.scan + 1,
                        measured=update.measured,
                        added=update.added,
                        before=update.before,
                        after=update.after,
                        weight=update.weight,
                    )
                    for update in updates[-MOST_UPDATES:]
                ],
            )
        )

    def met(self, origin: Point, direction: Point) -> tuple[Point, float] | None:
        """Return where a line of sight meets the surface, metres, and the side of its voxels; None if it does not."""
        place = first_surface(self.replayed.volume, np.array(origin), np.array(direction))
        return None if place is None else (rounded_place(place), self.config.resolution)

    def _key_of(self, command: VoxelCommand | VoxelRayCommand) -> Int64Array | None:
        """Return the key of the queried voxel; None if there is none."""
        place: Float64Array | None
        if isinstance(command, VoxelRayCommand):
            place = first_surface(self.replayed.volume, np.array(command.origin), np.array(command.direction))
        else:
            place = None if (place_xyz := place_of(command)) is None else np.array(place_xyz)
        if place is None:
            return None
        keys, inside = keys_of(place[None].astype(np.float32), self.config.resolution)
        if not inside[0]:
            raise ConfigError("volume.outside", f"The place {place.tolist()} lies outside of the map’s lattice.")
        return np.asarray(keys[0])
