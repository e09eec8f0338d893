"""Compressed images: read back unchanged, partly from a file; cancelled work ends."""

from __future__ import annotations

import asyncio
import threading
import tracemalloc
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import LimitError
from server.downloads import CompressedImage, Downloads
from server.downloads.compressed_image import MEMORY_BYTES
from server.downloads.downloads import StoppedError
from tests.server.service import PATIENCE_S, eventually


def anyway() -> None:
    """Let the work go on."""


@pytest.fixture
async def downloads(tmp_path: Path) -> AsyncIterator[Downloads]:
    made = Downloads(tmp_path)
    yield made
    await made.close()


def test_bands_are_read_back_unchanged_and_repeatedly(tmp_path: Path) -> None:
    pixels = np.random.default_rng(0).integers(0, 3, (100, 70), dtype=np.uint8)
    kept = CompressedImage(pixels.shape, np.split(pixels, [30, 31]), tmp_path, anyway)
    for _ in range(2):
        np.testing.assert_array_equal(np.concatenate(list(kept.bands())), pixels)
    first, second = kept.bands(), kept.bands()
    np.testing.assert_array_equal(next(first), next(second))
    np.testing.assert_array_equal(next(second), pixels[30:31])
    assert kept.nbytes < pixels.nbytes / 3


def test_pixels_that_do_not_compress_go_to_a_file_without_a_name(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    band = rng.integers(0, 256, (64, 1 << 14), dtype=np.uint8)
    tracemalloc.start()
    kept = CompressedImage((64 * 40, 1 << 14), (band + np.uint8(n) for n in range(40)), tmp_path, anyway)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert kept.nbytes > 40 << 20
    assert most < 3 * MEMORY_BYTES
    assert list(tmp_path.iterdir()) == []
    for number, again in enumerate(kept.bands()):
        np.testing.assert_array_equal(again, band + np.uint8(number))


async def test_work_that_is_cancelled_has_ended_when_the_call_returns(downloads: Downloads) -> None:
    begun, ended = threading.Event(), threading.Event()

    def work(check: Callable[[], None]) -> None:
        begun.set()
        try:
            while True:
                check()
        except StoppedError:
            ended.set()
            raise

    task = asyncio.create_task(downloads.run(work))
    assert await asyncio.to_thread(begun.wait, PATIENCE_S)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert ended.is_set()


async def test_work_that_was_cancelled_before_its_start_does_not_start(downloads: Downloads) -> None:
    release, ran = threading.Event(), threading.Event()
    running = [asyncio.create_task(downloads.run(lambda _: release.wait())) for _ in range(2)]
    await asyncio.sleep(0)
    waiting = asyncio.create_task(downloads.run(lambda _: ran.set()))
    await asyncio.sleep(0)
    waiting.cancel()
    await eventually(waiting.done)
    release.set()
    await asyncio.gather(*running)
    assert not ran.is_set()


async def test_a_full_disk_is_said(downloads: Downloads) -> None:
    def work(_: Callable[[], None]) -> None:
        raise OSError(28, "No space left on device")

    with pytest.raises(LimitError) as caught:
        await downloads.run(work)
    assert caught.value.code == "log.storage"
