"""A library in a temporary folder; the reading process is shared by the module, since starting one is slow."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import pytest_asyncio

from mapper.simulation import sample_log
from server.library.library import Library
from server.library.loading import LibraryLimits
from server.library.processing.reader import Reader, Readers
from server.settings import Settings
from tests.server.library.postgresql import Cluster, running_postgresql
from tests.server.service import PATIENCE_S


@pytest.fixture(scope="session")
def postgresql() -> Iterator[Cluster]:
    """A PostgreSQL server of this worker."""
    with running_postgresql() as cluster:
        yield cluster


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    folder = tmp_path / "shared logs"
    folder.mkdir()
    values: dict[str, Any] = {"data_dir": tmp_path / "data", "logs_dir": folder, "max_upload_bytes": 1_000_000}
    return Settings(**values)


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def reader() -> AsyncIterator[Reader]:
    # A visitor's log has two minutes, in which a busy machine may not even have started the process that reads.
    reader = Reader(timeout_s=PATIENCE_S, memory_bytes=LibraryLimits().read_memory_bytes)
    yield reader
    await reader.close()


@pytest.fixture(autouse=True)
def _short_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """The sample as short as a sample can be: every list of logs has it made."""
    monkeypatch.setattr("server.library.logs.sample.simulation", SimpleNamespace(sample_log=lambda: sample_log(5)))


Make = Callable[..., "Library"]


@pytest_asyncio.fixture(loop_scope="module")
async def make_library(settings: Settings, reader: Reader) -> AsyncIterator[Make]:
    """Makes libraries; one with limits, or asked to, has a reader of its own."""
    made: list[Library] = []

    def make(*, own_reader: bool = False, **limits: float) -> Library:
        shared = None if own_reader or limits else Readers(reader, reader)
        library = Library(settings, LibraryLimits(**limits), readers=shared)  # type: ignore[arg-type]
        made.append(library)
        return library

    yield make
    for library in made:
        await library.close()


@pytest_asyncio.fixture(loop_scope="module")
async def library(make_library: Make) -> Library:
    library = make_library()
    await library.start()
    return library
