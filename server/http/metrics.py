"""Prometheus metrics, in their own registry."""

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
        """Include the figures of ``sessions``, which have these kinds, in each answer."""
        self._registry.register(_SessionCollector(sessions, tuple(kinds), self.traffic))

    def text(self) -> bytes:
        """Return all figures in Prometheus' text format."""
        return generate_latest(self._registry)


def summed(texts: Iterable[bytes]) -> bytes:
    """Return the sums of several workers' figures, given in Prometheus' text format.

    Creation times (``…_created``) are those of the first worker.
    """
    registry = CollectorRegistry()
    registry.register(_Summed([*map(bytes.decode, texts)]))
    return generate_latest(registry)


class _Summed(Collector):
    def __init__(self, texts: Sequence[str]) -> None:
        self._texts = texts

    def collect(self) -> Iterable[Metric]:
        from prometheus_client.parser import text_string_to_metric_families  # noqa: PLC0415 - for several workers only

        families: dict[str, Metric] = {}
        sums: dict[str, dict[tuple[str, tuple[tuple[str, str], ...]], float]] = {}
        for text in self._texts:
            for family in text_string_to_metric_families(text):
                families.setdefault(family.name, Metric(family.name, family.documentation, family.type))
                values = sums.setdefault(family.name, {})
                for sample in family.samples:
                    key = (sample.name, tuple(sample.labels.items()))
                    is_time = sample.name.endswith("_created") and key in values
                    values[key] = values[key] if is_time else values.get(key, 0.0) + sample.value
        for name, family in families.items():
            for (sample_name, labels), value in sums[name].items():
                family.add_sample(sample_name, dict(labels), value)
            yield family


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
