"""The pose graph of a log session's trajectory: its layer, its questions and its manual changes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from mapper.core.errors import ConfigError
from mapper.io import export
from mapper.sensors.scan import ScanLog
from server.parts.slam.solved_graph import ShowGraph
from server.sessions.drawings import Drawing, Segments
from server.sessions.hosting import ModelHost
from server.sessions.part import Part
from server.sessions.parts import Graphed, GraphSource, Recording, ShownLoops
from server.sessions.tick import TickResult
from server.sessions.view import GraphChange
from server.stream.layers import GraphLayer

if TYPE_CHECKING:
    from mapper.io.contents.model import Series
    from server.parts.slam.solved_graph import SolvedGraph
    from server.sessions.graph_answers import (
        EdgeAnswer,
        PoseGraphAnswer,
        ScanConstraints,
        ScoreLandscape,
        TriedLoopScans,
        TriedNear,
    )

LAYER = "graph"


def read_solved(data: bytes, log: ScanLog, trajectory: str) -> SolvedGraph:
    """Return the solution of the graph file of a trajectory of ``log`` (worker thread).

    Raises :class:`mapper.core.errors.MapperError` for an invalid file, or one that belongs to other scans.
    """
    from server.library.packs.graph import read_graph  # noqa: PLC0415 - imports SLAM and SciPy, which few sessions need
    from server.parts.slam.solved_graph import SolvedGraph  # noqa: PLC0415

    graph, candidates = read_graph(data)
    if len(graph.nodes) and int(graph.nodes.max()) >= log.n_scans:
        raise ConfigError("graph.none", "This pose graph belongs to the scans of another sensor of the log.")
    return SolvedGraph.of(trajectory, log.trajectory(trajectory).poses, graph, candidates)


def files_of(solved: SolvedGraph, log: ScanLog) -> tuple[bytes, bytes]:
    """Return the current poses of a graph as TUM lines of ``log``, and the graph as a file (worker thread)."""
    from server.library.packs.graph import graph_bytes  # noqa: PLC0415

    graph = replace(solved.graph, poses=solved.node_poses)
    text = export.tum_text(solved.in_log(log), solved.trajectory)
    return text.encode(), graph_bytes(graph, solved.candidates)


class LogGraph(Part, Graphed):
    """The graph of a log session's current trajectory, if it has one, and its layer."""

    commands = (ShowGraph,)
    is_on = False  # until the graph of a trajectory is requested

    def __init__(
        self, host: ModelHost, recording: Recording, update_log: Callable[[ScanLog, TickResult], None]
    ) -> None:
        self._host, self._recording, self._update_log = host, recording, update_log
        self._newest: SolvedGraph | None = None  #: which the model may not show yet
        self._unshown: SolvedGraph | None = None  #: which was read only for its residuals
        self._changing = asyncio.Lock()  #: held while the graph is read or changed
        self._shown: SolvedGraph | None = None
        self._layer: GraphLayer | None = None
        self._loops: ShownLoops | None = None
        self._drawing: Segments | None = None  #: of these

    # -- on a worker thread ---------------------------------------------------------------------------------------

    @property
    def layers(self) -> tuple[GraphLayer, ...]:
        """The layer of the graph, while the map uses its trajectory."""
        is_shown = self._shown is not None and self._shown.trajectory == self._recording.trajectory
        return (self._layer,) if is_shown and self._layer is not None else ()

    @property
    def loops(self) -> ShownLoops | None:
        """The loops of the graph in the layer."""
        return self._loops if self.layers else None

    def drawings(self) -> list[Drawing]:
        """Return the loops as lines."""
        return [self._drawing] if self._drawing is not None and self.layers else []

    def handle(self, command: ShowGraph, result: TickResult) -> None:
        """Write another graph into the layer, and map the log along its poses."""
        solved = self._shown = command.solved
        self.is_on = True
        self._layer = self._layer or GraphLayer(LAYER, "Pose graph", "pose_graph", ("x", "y", "yaw", "scan"))
        solved.draw(self._layer)
        self._loops, self._drawing = solved.in_3d()
        self._update_log(solved.in_log(self._recording.log), result)
        result.changed = True

    # -- on the event loop --------------------------------------------------------------------------------------

    async def public(self, source: GraphSource) -> PoseGraphAnswer:
        """Return the loops of the current trajectory's graph, and show its layer.

        ``source`` reads the graph's file. Raises :class:`ConfigError` for a trajectory without a graph.
        """
        async with self._changing:
            return (await self._present(source)).public()

    async def edge(self, edge: int, source: GraphSource) -> EdgeAnswer:
        """Return an edge with both of its scans. Raises like :meth:`public` and :meth:`SolvedGraph.edge`."""
        async with self._changing:
            solved = await self._present(source)
        return await self._host.on_thread(partial(solved.edge, self._recording.log, edge))

    async def constraints(self, scan: int, source: GraphSource) -> ScanConstraints:
        """Return the edges that determine the pose of a scan. Raises like :meth:`public`, and for an unknown scan."""
        async with self._changing:
            solved = await self._present(source)
        return await self._host.on_thread(partial(solved.constraints, scan))

    async def landscape(self, edge: int, source: GraphSource) -> ScoreLandscape:
        """Return the scores of the poses around an edge. Raises like :meth:`edge`."""
        from server.parts.slam.loop_landscape import (  # noqa: PLC0415 - imports SLAM, few need it
            landscape_of,
        )

        async with self._changing:
            solved = await self._present(source)
        return await self._host.on_thread(partial(landscape_of, solved, self._recording.log, edge))

    async def residuals(self, source: GraphSource) -> Series:
        """Return the residuals of the graph's measurements over time. Raises like :meth:`public`."""
        async with self._changing:
            solved = await self._read(source)
        return await self._host.on_thread(partial(solved.residuals, self._recording.log))

    async def near(self, x: float, y: float, source: GraphSource) -> TriedNear:
        """Return the loops that were tried near a place. Raises like :meth:`public`."""
        async with self._changing:
            solved = await self._present(source)
        return await self._host.on_thread(partial(solved.near, x, y))

    async def candidate(self, candidate: int, source: GraphSource) -> TriedLoopScans:
        """Return a tried loop with both of its scans. Raises like :meth:`public`."""
        async with self._changing:
            solved = await self._present(source)
        return await self._host.on_thread(partial(solved.candidate, self._recording.log, candidate))

    async def change(self, change: GraphChange, source: GraphSource) -> PoseGraphAnswer:
        """Change the graph, solve it and map the log along its poses; return the same as :meth:`public`.

        Raises :class:`mapper.core.errors.MapperError` for an impossible change; nothing has changed then.
        """
        async with self._changing:
            solved = await self._present(source)
            solved = await self._host.on_thread(partial(solved.changed, self._recording.log, change))
            self._give(solved)
            return solved.public()

    async def files(self, source: GraphSource) -> tuple[str, bytes, bytes]:
        """Return the name of the trajectory, its current poses as TUM lines, and the file of the current graph."""
        async with self._changing:
            solved = await self._present(source)
        return (solved.trajectory, *await self._host.on_thread(partial(files_of, solved, self._recording.log)))

    async def _present(self, source: GraphSource) -> SolvedGraph:
        """Return the graph of the current trajectory, and show it."""
        solved = await self._read(source)
        if solved is not self._newest:
            self._give(solved)
        return solved

    async def _read(self, source: GraphSource) -> SolvedGraph:
        """Return the graph of the current trajectory; read and solve it if necessary."""
        name, log = self._recording.trajectory, self._recording.log
        for known in (self._newest, self._unshown):
            if known is not None and known.trajectory == name:
                return known
        data = await source(name)
        if data is None:
            raise ConfigError(
                "graph.none", f"The trajectory {name!r:.90} has no pose graph: heal the log’s poses first."
            )
        self._unshown = await self._host.on_thread(partial(read_solved, data, log, name))
        return self._unshown

    def _give(self, solved: SolvedGraph) -> None:
        """Make the model show a graph and its poses."""
        self._newest, self._unshown = solved, None
        self._host.enqueue(ShowGraph(solved))

    def forget(self) -> None:
        """Reread the graph on the next request, because its trajectory was replaced."""
        self._newest = self._unshown = None
