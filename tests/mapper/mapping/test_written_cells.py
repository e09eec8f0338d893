"""The cells that an update of one scan lists: all those that it changed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mapper.mapping import integrate
from mapper.simulation import WORLDS
from mapper.simulation.live_map import LiveMap


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"clamp": False},
        {"window": 0.4},
        {"log_odds_prior": -2.0},
        {"no_return": "free", "range_max": 3.0},
        {"log_odds_min": -0.5, "log_odds_max": 0.9},
        {"hit_and_passed": "only_hits"},
        {"hit_and_passed": "only_hits", "window": 0.4, "log_odds_min": -0.5, "log_odds_max": 0.9},
    ],
)
def test_the_listed_cells_hold_all_that_changed(values: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(integrate, "MOST_WRITTEN", 1 << 17)  # without a clamp every cell of a scan is written
    mapper = LiveMap(WORLDS["room"], seed=3)
    mapper.remake(mapper.config.with_values(values))
    listed = 0
    for _ in range(30):
        before, seen = mapper.grid.log_odds.copy(), mapper.grid.observed.copy()
        changes = [change for change in mapper.advance(0.1) if change.box is not None]
        expected = np.flatnonzero((mapper.grid.log_odds != before) | (mapper.grid.observed != seen))
        cells: set[int] = set()
        for change in changes:
            assert change.cells is not None
            assert change.box is not None
            row, col = np.divmod(change.cells, mapper.grid.geometry.cols)
            assert (row >= change.box.row0).all()
            assert (row < change.box.row1).all()
            assert (col >= change.box.col0).all()
            assert (col < change.box.col1).all()
            cells.update(change.cells.tolist())
        assert cells.issuperset(expected.tolist())
        listed += len(expected)
    assert listed > 100


def test_more_cells_than_there_is_room_for_are_not_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    mapper, other = (LiveMap(WORLDS["room"], seed=3) for _ in range(2))
    (change,) = mapper.advance(0.1)
    assert change.cells is not None
    monkeypatch.setattr(integrate, "MOST_WRITTEN", len(change.cells) - 1)
    (unlisted,) = other.advance(0.1)
    assert unlisted.cells is None
    assert unlisted == change
    assert mapper.grid.log_odds.tobytes() == other.grid.log_odds.tobytes()
