"""Prometheus metrics, in a registry of their own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from prometheus_client import CollectorRegistry, Histogram, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from server.sessions import SessionRegistry
from server.stream.traffic import Traffic

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"


class Metrics:
    """The metrics of ``/metrics``. Counters are updated where events occur; session figures are read on request."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        self.traffic = Traffic()
        self.remake_seconds = Histogram(
            "gridbloom_remake_seconds",
            "Time to make a whole map again with other parameters.",
            buckets=(0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 10.0),
            registry=self._registry,
        )

    def watch(self, sessions: SessionRegistry, kinds: Iterable[str]) -> None:
        """Include the figures of ``sessions``, which are of these kinds, in each answer."""
        self._registry.register(_SessionCollector(sessions, tuple(kinds), self.traffic))

    def text(self) -> bytes:
        """Return all figures in Prometheus' text format."""
        return generate_latest(self._registry)


class _SessionCollector(Collector):
    def __init__(self, sessions: SessionRegistry, kinds: Sequence[str], traffic: Traffic) -> None:
        self._sessions, self._kinds = sessions, kinds
        self._traffic = traffic

    def collect(self) -> Iterable[Metric]:
        live = self._sessions.all()
        by_kind = GaugeMetricFamily("gridbloom_sessions", "Live sessions.", labels=["kind"])
        for kind in self._kinds:
            by_kind.add_metric([kind], sum(s.model.kind == kind for s in live))
        yield by_kind
        clients = [client for session in live for client in session.hub.clients]
        yield GaugeMetricFamily("gridbloom_clients", "Browsers that watch a session.", value=len(clients))
        dirty = sum(client.dirty_tiles for client in clients)
        yield GaugeMetricFamily("gridbloom_dirty_tiles", "Tiles that clients have yet to be sent.", value=dirty)
        cells = sum(session.cells for session in live)
        yield GaugeMetricFamily("gridbloom_cells", "Cells of all grids.", value=cells)
        sent = self._traffic
        yield CounterMetricFamily("gridbloom_frames", "Binary frames sent.", value=sent.frames)
        yield CounterMetricFamily("gridbloom_tiles", "Tiles sent.", value=sent.tiles)
        yield CounterMetricFamily("gridbloom_stream_bytes", "Bytes sent on streams.", value=sent.bytes)
