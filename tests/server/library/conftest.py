"""A library in a folder of the test's own."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import pytest

from server.library import Library, LibraryLimits
from server.settings import Settings


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    folder = tmp_path / "shared logs"
    folder.mkdir()
    values: dict[str, Any] = {"data_dir": tmp_path / "data", "logs_dir": folder, "max_upload_bytes": 1_000_000}
    return Settings(**values)


Make = Callable[..., "Library"]


@pytest.fixture
async def make_library(settings: Settings) -> AsyncIterator[Make]:
    made: list[Library] = []

    def make(**limits: float) -> Library:
        library = Library(settings, LibraryLimits(**limits))  # type: ignore[arg-type]
        made.append(library)
        return library

    yield make
    for library in made:
        await library.close()


@pytest.fixture
async def library(make_library: Make) -> Library:
    library = make_library()
    await library.start()
    return library
