"""Results are equal to the last bit with any number of threads; rows are divided completely and evenly."""

import os
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mapper.mapping.update
from mapper.core.parallel import bands, cores, in_parallel, scratch, single_threaded
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import geometry_for, integrate_log
from mapper.mapping.parameters import MODELS, MappingConfig
from mapper.sensors.scan import ScanLog


@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
@pytest.mark.parametrize("window", [0.0, 0.3])
@pytest.mark.parametrize("model", [model for model in MODELS if model != "step_window"])
def test_the_number_of_threads_does_not_show(
    office_log: ScanLog, model: str, update: str, window: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    _same_by_any_number_of_threads(
        office_log,
        MappingConfig(model=model, update=update, window=window, no_return="free", resolution=0.1, opening=0.1),
        monkeypatch,
    )


@pytest.mark.parametrize("traversal", ["bresenham", "amanatides_woo"])
@pytest.mark.parametrize("window", [0.0, 0.3])
def test_nor_does_it_where_only_hits_count(
    office_log: ScanLog, traversal: str, window: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = MappingConfig(hit_and_passed="only_hits", traversal=traversal, window=window, resolution=0.1)
    _same_by_any_number_of_threads(office_log, config, monkeypatch)


def _same_by_any_number_of_threads(office_log: ScanLog, config: MappingConfig, monkeypatch: pytest.MonkeyPatch) -> None:
    geometry = geometry_for(office_log, config)
    maps = []
    for threads in (1, 2, 3, 7):
        monkeypatch.setattr(mapper.mapping.update, "cores", lambda threads=threads: threads)
        grid = OccupancyGrid(geometry)
        maps.append((integrate_log(grid, office_log, config), grid.log_odds.tobytes(), grid.observed.tobytes()))
    assert all(other == maps[0] for other in maps[1:])


@given(st.lists(st.integers(0, 100), min_size=1, max_size=60), st.integers(1, 9))
def test_bands_cover_all_rows_in_equal_shares(work: list[int], parts: int) -> None:
    split = bands(np.array(work, dtype=float), parts)
    assert [row for low, high in split for row in range(low, high)] == list(range(len(work)))
    assert len(split) <= parts
    share = sum(work) / parts + max(work)
    assert all(sum(work[low:high]) <= share for low, high in split)


def test_results_come_in_order() -> None:
    assert in_parallel([partial(pow, n, 2) for n in range(20)]) == [n * n for n in range(20)]


def test_scratch_is_zero_also_after_an_error() -> None:
    with scratch(8) as words:
        words[:] = 1
        words[:] = 0

    def fail(words: np.ndarray) -> None:
        words[:] = 7
        raise KeyError

    with pytest.raises(KeyError), scratch(4) as words:
        fail(words)
    with scratch(6) as words:
        assert len(words) >= 6
        assert not words.any()


def test_single_threaded_uses_one_core_and_ends_with_the_block(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1, 2}, raising=False)
    assert cores() == 3
    with single_threaded():
        with single_threaded():
            assert cores() == 1
        assert cores() == 1
        assert in_parallel([cores]) == [1]
    assert cores() == 3
