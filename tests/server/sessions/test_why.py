"""The explanation of a cell: against the textbook, the map, and the limit on the size of a message."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from mapper.core.se2 import compose
from mapper.mapping import textbook, textbook_deskew
from mapper.sensors.scan import ScanLog
from server.parts.why.part import MAX_CONTRIBUTIONS, STRETCHES, thinned
from server.parts.wire import command_of
from server.sessions import SessionRegistry
from tests.mapper.mapping.sweeping import swept
from tests.server.begin import new_log, new_simulation


async def answer(obey: Callable[..., Any], session: Any, **question: Any) -> dict[str, Any]:
    """Ask a session and return what it says: a ``why`` or an ``error``."""
    client = session.join()
    client.take()
    session.enqueue(command_of({"type": "why", "epoch": session.model.layers[0].epoch} | question), client)
    await obey(session, type="pause")
    said = [json.loads(message) for message in client.take() if isinstance(message, str)]
    session.leave(client)
    found: list[dict[str, Any]] = [message for message in said if message["type"] in ("why", "error")]
    assert len(found) == 1
    return found[0]


def some_cells(session: Any, n: int) -> list[tuple[int, int]]:
    """Return cells of the map: occupied ones, others that were seen, and one that never was."""
    grid, random = session.model.grid, np.random.default_rng(11)
    kinds = (np.argwhere(grid.log_odds > 1.0), np.argwhere(grid.observed), np.argwhere(~grid.observed)[:1])
    return [(int(row), int(col)) for cells in kinds for row, col in random.permutation(cells)[:n]]


async def test_every_touch_is_the_textbooks(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await new_log(registry, "me", office_log)
    await obey(session, type="pause")
    await obey(session, type="seek", index=12)
    await obey(session, type="parameters", values={"resolution": 0.2, "mount_x": 0.1, "range_max": 8.0})
    poses = compose(office_log.sensor_poses()[:12], np.array(session.model.config.mount))
    scans = [office_log.scan(i) for i in range(12)]
    outweighed = 0
    for row, col in some_cells(session, 3):
        expected = textbook.provenance(session.model.grid, scans, poses, (row, col), session.model.config)
        told = await answer(obey, session, row=row, col=col)
        assert (told["index"], told["total"], told["per_scan"]) == (12, len(expected), False)
        assert told["hits"] == sum(evidence > 0 for _, _, evidence, _ in expected)
        assert told["outweighed"] == sum(evidence == 0 for _, _, evidence, _ in expected)
        outweighed += told["outweighed"]
        assert told["first_scan"] == (expected[0][0] if expected else None)
        assert told["log_odds"] == session.model.grid.log_odds[row, col]
        newest = expected[-MAX_CONTRIBUTIONS:]
        assert [(t["scan"], t["beam"]) for t in told["contributions"]] == [(scan, beam) for scan, beam, _, _ in newest]
        for n, touch, (scan, beam, evidence, log_odds) in zip(
            range(len(expected) - len(newest) + 1, len(expected) + 1), told["contributions"], newest, strict=True
        ):
            z = float(scans[scan].ranges[beam])
            assert touch["n"] == n
            assert touch["hit"] is (evidence > 0)
            assert touch.get("outweighed", False) is (evidence == 0)
            assert touch["increment"] == pytest.approx(evidence, abs=1e-6)
            assert touch["log_odds"] == pytest.approx(float(log_odds), abs=1e-6)
            assert touch["pose"] == pytest.approx(poses[scan], abs=1e-4)
            assert touch["bearing"] == pytest.approx(scans[scan].angles[beam], abs=1e-5)
            assert touch["range"] == pytest.approx(z, abs=1e-3)
    assert outweighed > 0


@pytest.mark.parametrize("update", ["per_beam", "per_scan"])
async def test_the_last_value_is_the_maps(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog, update: str
) -> None:
    session = await new_log(registry, "me", office_log)
    await obey(session, type="pause")
    await obey(session, type="seek", index=office_log.n_scans)
    await obey(session, type="parameters", values={"update": update, "clamp": False, "no_return": "free"})
    for row, col in some_cells(session, 6):
        told = await answer(obey, session, row=row, col=col)
        assert (told["log_odds_min"], told["log_odds_max"]) == (None, None)
        assert told["per_scan"] is (update == "per_scan")
        if told["total"]:
            assert told["contributions"][-1]["n"] == told["curve"][-1][0] == told["total"]
            assert told["contributions"][-1]["log_odds"] == pytest.approx(told["log_odds"], abs=1e-5)
        else:
            assert told["log_odds"] == told["prior"]
            assert (told["contributions"], told["curve"]) == ([], [])


async def test_a_deskewed_beam_has_the_pose_of_its_own_time(
    registry: SessionRegistry, obey: Callable[..., Any]
) -> None:
    log = swept(12)
    session = await new_log(registry, "me", log)
    await obey(session, type="pause")
    await obey(session, type="seek", index=11)
    values = session.model.config.with_values({"mount_yaw": 0.02})
    await obey(session, type="parameters", values={"mount_yaw": 0.02})
    one_by_one = [textbook_deskew.deskewed(log, t, values) for t in range(11)]
    hits = 0
    for row, col in some_cells(session, 8):
        said = await answer(obey, session, row=row, col=col)
        assert said["type"] == "why"
        for one in said["contributions"]:
            _, direction = one_by_one[one["scan"]][one["beam"]]
            x, y, yaw = one["pose"]
            np.testing.assert_allclose([x, y], direction[:2], atol=1e-3)
            assert np.exp(1j * (yaw + one["bearing"])) == pytest.approx(np.exp(1j * direction[2]), abs=1e-3)
            hits += one["hit"]
    assert hits > 0


async def test_a_live_world_tells_of_all_its_sensors(registry: SessionRegistry, obey: Callable[..., Any]) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    await obey(session, type="pause")
    await obey(session, type="step", scans=10)
    await obey(session, type="sensor", values={"n_beams": 90})
    await obey(session, type="step", scans=10)
    lengths = [source.stop for source in session.model.sources()]
    assert len(lengths) == 2
    both = 0
    for row, col in some_cells(session, 8):
        told = await answer(obey, session, row=row, col=col)
        if told["total"] == 0:
            continue
        assert told["contributions"][-1]["log_odds"] == pytest.approx(told["log_odds"], abs=1e-6)
        assert [t["n"] for t in told["contributions"]] == list(
            range(told["total"] - len(told["contributions"]) + 1, told["total"] + 1)
        )
        scans = [t["scan"] for t in told["contributions"]]
        assert scans == sorted(scans)
        both += told["first_scan"] < lengths[0] <= scans[-1]
        # Each touch goes on from where the one before it left the cell, over the change of the sensor as well.
        for touch, following in zip(told["contributions"], told["contributions"][1:], strict=False):
            assert following["log_odds"] == pytest.approx(
                float(np.clip(touch["log_odds"] + following["increment"], -2.0, 3.5)), abs=1e-5
            )
    assert both > 0


async def test_earlier_contributions_can_be_requested(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await new_log(registry, "me", office_log)
    await obey(session, type="pause")
    await obey(session, type="seek", index=office_log.n_scans)
    x, y, _ = office_log.trajectory(None).poses[0]
    row, col = (int(i) for i in session.model.grid.geometry.world_to_cell((x, y)))
    newest = await answer(obey, session, row=row, col=col)
    assert newest["total"] > MAX_CONTRIBUTIONS == len(newest["contributions"])  # beams start here
    first = await answer(obey, session, row=row, col=col, until=40)
    assert [touch["n"] for touch in first["contributions"]] == list(range(1, 41))
    assert first["contributions"][0]["scan"] == first["first_scan"] == 0
    assert {key: first[key] for key in first if key != "contributions"} == {
        key: newest[key] for key in newest if key != "contributions"
    }
    assert (await answer(obey, session, row=row, col=col, until=10**9))["contributions"] == newest["contributions"]
    assert len(json.dumps(newest, separators=(",", ":"))) < 80_000


@pytest.mark.parametrize(
    ("question", "code"),
    [
        ({"row": -1, "col": 0}, "command.cell"),
        ({"row": 0, "col": 10**6}, "command.cell"),
        ({"row": 0, "col": 0, "epoch": 99}, "command.epoch"),
        ({"row": 0, "col": 0, "until": 0}, "command.until"),
    ],
)
async def test_a_question_that_has_no_answer(
    registry: SessionRegistry, obey: Callable[..., Any], question: dict[str, Any], code: str
) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    await obey(session, type="pause")
    said = await answer(obey, session, **question)
    assert (said["type"], said["code"]) == ("error", code)


@pytest.mark.usefixtures("one_tick")
async def test_of_many_questions_the_last_is_answered(registry: SessionRegistry, obey: Callable[..., Any]) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    await obey(session, type="pause")
    epoch = session.model.layers[0].epoch
    for col in range(20):
        session.enqueue(command_of({"type": "why", "row": 0, "col": col, "epoch": epoch}), None)
    assert (await answer(obey, session, row=3, col=5))["col"] == 5
    client = session.join()
    client.take()
    for col in range(20):
        session.enqueue(command_of({"type": "why", "row": 0, "col": col, "epoch": epoch}), client)
    await obey(session, type="pause")
    said = [json.loads(message) for message in client.take() if isinstance(message, str)]
    assert [message["col"] for message in said if message["type"] == "why"] == [19]


@pytest.mark.parametrize("n", [0, 1, 600, 601, 5000])
def test_a_thinned_curve_keeps_its_extremes(n: int) -> None:
    log_odds = np.random.default_rng(n).normal(size=n).astype(np.float32)
    if n > 1000:
        log_odds[777] = 9.0
    curve = thinned(log_odds)
    assert len(curve) <= 2 * STRETCHES
    numbers = [int(i) for i, _ in curve]
    assert numbers == sorted(set(numbers))
    assert all(
        value == pytest.approx(float(log_odds[i - 1]), abs=1e-4)
        for i, value in zip(numbers, (v for _, v in curve), strict=True)
    )
    if n:
        assert numbers[-1] == n
        assert {round(float(log_odds.min()), 4), round(float(log_odds.max()), 4)} <= {v for _, v in curve}
