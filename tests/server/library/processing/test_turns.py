"""Computations that keep a process wait in turns by address: a client without cookies gets one turn like any other."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from server.jobs.process import JobLimits
from server.library.processing.inspections import Inspections
from server.library.processing.reference_maps import ReferenceMaps
from server.library.processing.relation_scores import MeanErrors, RelationMeans, RelationScores

LIMITS = JobLimits(60.0, 60.0, 1 << 30)
MANY, ONE = "198.51.100.7", "203.0.113.9"

Compute = Callable[[str, str], Awaitable[Any]]


class Catalogue:
    """Files of no log."""

    @asynccontextmanager
    async def source(self, record: Any) -> AsyncIterator[Path]:
        yield Path(record.name)

    def contents(self, log_id: str) -> Path:
        return Path(log_id)


def scores(monkeypatch: pytest.MonkeyPatch, folder: Path, done: Callable[[], Awaitable[Any]]) -> Compute:
    made = RelationScores(Catalogue(), folder, LIMITS)  # type: ignore[arg-type] # a stand-in
    log: Any = SimpleNamespace(stamps_ns=np.zeros(1, np.int64), trajectory=lambda _: SimpleNamespace(poses=None))
    record: Any = SimpleNamespace(source="sample", name="sample")

    async def told(*_: Any) -> RelationMeans:
        await done()
        return RelationMeans(relations=0, policy="time", left_out=0, all=MeanErrors(0, 0.0, 0.0), unambiguous=None)

    monkeypatch.setattr("server.library.processing.recording_worker.outcome_of", told)
    return lambda visitor, address: made.score(record, visitor, log, "scan", b"", "a", None, address=address)


def inspections(monkeypatch: pytest.MonkeyPatch, folder: Path, done: Callable[[], Awaitable[Any]]) -> Compute:
    made = Inspections(Catalogue(), LIMITS)  # type: ignore[arg-type] # a stand-in

    async def told(*_: Any) -> None:
        await done()

    monkeypatch.setattr("server.library.processing.recording_worker.outcome_of", told)
    lookups = made.lookups

    def inspect(visitor: str, address: str) -> Awaitable[Any]:
        record: Any = SimpleNamespace(id=visitor, name=visitor)
        return lookups._look_up(visitor, record, visitor, address, lambda _: None)  # type: ignore[arg-type,return-value]

    return inspect


def maps(monkeypatch: pytest.MonkeyPatch, folder: Path, done: Callable[[], Awaitable[Any]]) -> Compute:
    made = ReferenceMaps(SimpleNamespace(), SimpleNamespace, folder, lambda: 0, SimpleNamespace())  # type: ignore[arg-type] # stand-ins
    monkeypatch.setattr(made, "_worker", SimpleNamespace(submit=lambda _: None))

    async def told(*_: Any) -> None:
        await done()

    async def put(*_: Any) -> None:
        pass

    monkeypatch.setattr("server.library.processing.reference_maps.outcome_of", told)
    monkeypatch.setattr(made, "_put", put)
    return lambda visitor, address: made._made(visitor, address, "log", folder, "map", None)


@pytest.mark.parametrize("compute_of", [scores, inspections, maps])
async def test_a_client_with_many_cookies_has_others_wait_for_one_of_its_turns(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, compute_of: Any
) -> None:
    order: list[str] = []
    ready = asyncio.Event()

    async def done() -> None:
        task = asyncio.current_task()
        assert task is not None
        order.append(task.get_name())  # at its turn: what follows it may be left to threads
        await ready.wait()

    compute = compute_of(monkeypatch, tmp_path, done)

    async def request(visitor: str, address: str) -> None:
        await compute(visitor, address)

    waiting = []
    for visitor, address in [*((f"cookie {k}", MANY) for k in range(5)), ("ann", ONE)]:
        waiting.append(asyncio.create_task(request(visitor, address), name=visitor))
        await asyncio.sleep(0)
    ready.set()
    await asyncio.gather(*waiting)
    assert order.index("ann") <= 2
