"""A log's map compared with another one: which parameters follow, and the numbers against plain NumPy."""

from __future__ import annotations

import asyncio
import io
from collections.abc import Callable, Iterator
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from mapper.core.errors import ConfigError, MapperError
from mapper.core.limits import Limits
from mapper.mapping.parameters import MappingConfig
from mapper.sensors.scan import ScanLog
from server.sessions import LogView, SessionRegistry
from server.sessions.view import MapRequest
from tests.server.begin import new_log
from tests.server.service import Service, Watcher, eventually, running, settings_for
from tests.server.sessions.test_log import whole_map


async def at_its_end(registry: SessionRegistry, obey: Callable[..., Any], log: ScanLog) -> Any:
    session = await new_log(registry, "me", log)
    await obey(session, type="pause")
    await obey(session, type="seek", index=log.n_scans)
    return session


async def test_map_a_keeps_its_parameters_while_those_of_b_change(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await at_its_end(registry, obey, office_log)
    kept = session.model.config
    await session.model.comparison.compare(MapRequest(asdict(kept), session.model.recording.trajectory))
    _, found = await session.model.comparison.compared()
    assert found.max_difference == 0.0
    await obey(session, type="parameters", values={"log_odds_hit": 0.4, "window": 0.2})
    other = session.model.comparison.explained()[0]
    np.testing.assert_array_equal(other.grid.log_odds, whole_map(office_log, kept).log_odds)
    np.testing.assert_array_equal(session.model.grid.log_odds, whole_map(office_log, session.model.config).log_odds)
    _, found = await session.model.comparison.compared()
    assert found.max_difference > 0.5
    # Both stand at the same scan, forwards and backwards.
    for index in (30, 55):
        await obey(session, type="seek", index=index)
        other = session.model.comparison.explained()[0]
        assert other.index == index
        np.testing.assert_array_equal(other.grid.log_odds, whole_map(office_log, kept, stop=index).log_odds)


async def test_another_trajectory_follows_all_parameters(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await at_its_end(registry, obey, office_log)
    wheel = next(name for name in office_log.trajectories if name != session.model.recording.trajectory)
    await session.model.comparison.compare(MapRequest({}, wheel))
    for values in ({"update": "per_scan"}, {"resolution": 0.1}):
        await obey(session, type="parameters", values=values)
        other = session.model.comparison.explained()[0]
        assert other.config == session.model.config
        from mapper.mapping.integrate import grid_for, integrate_log

        expected = grid_for(office_log, session.model.config, wheel)
        integrate_log(expected, office_log, session.model.config, wheel)
        np.testing.assert_array_equal(other.grid.log_odds, expected.log_odds)
    told, _ = await session.model.comparison.compared()
    assert (told.trajectory, told.values, told.log) == (wheel, {}, None)


async def test_maps_without_a_common_lattice_are_shown_with_the_reason(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await at_its_end(registry, obey, office_log)
    client = session.join()
    await session.model.comparison.compare(MapRequest(asdict(session.model.config), session.model.recording.trajectory))
    await obey(session, type="parameters", values={"resolution": 0.1})
    with pytest.raises(MapperError, match=r"A has cells of 0\.05 m and B of 0\.1 m") as error:
        await session.model.comparison.compared()
    assert error.value.code == "compare.lattice"
    await eventually(lambda: '"refused":"A has cells' in session.hub.slots.get("comparison", ""))
    assert session.model.comparison.explained()[0].grid.geometry.resolution == 0.05
    session.leave(client)


async def test_a_bad_wish_changes_nothing_and_the_newest_wins(
    registry: SessionRegistry, obey: Callable[..., Any], office_log: ScanLog
) -> None:
    session = await at_its_end(registry, obey, office_log)
    with pytest.raises(MapperError, match="no comparison"):
        await session.model.comparison.compared()
    await session.model.comparison.compare(MapRequest({"window": 0.2}))
    for wanted in (MapRequest({"window": 9.0}), MapRequest({}, "no such poses"), MapRequest({"no such": 1})):
        with pytest.raises(ConfigError):
            await session.model.comparison.compare(wanted)
        told, _ = await session.model.comparison.compared()
        assert told.values == {"window": 0.2}
    done = await asyncio.gather(
        *(session.model.comparison.compare(MapRequest({"window": w})) for w in (0.3, 0.4, 0.5)), return_exceptions=True
    )
    assert done[2] is None
    assert [getattr(one, "code", None) for one in done[:2]] == ["compare.superseded"] * 2
    assert (await session.model.comparison.compared())[0].values == {"window": 0.5}
    with pytest.raises(MapperError):
        await new_log(registry, "me", replace(office_log, name="x"), view=LogView(trajectory="no such"))
    await session.model.comparison.compare(None)
    with pytest.raises(MapperError, match="no comparison"):
        await session.model.comparison.compared()


async def test_a_map_that_grows_too_large_for_either_changes_neither(
    make_registry: Callable[..., SessionRegistry], obey: Callable[..., Any], office_log: ScanLog
) -> None:
    cells = int(whole_map(office_log, MappingConfig()).log_odds.size)
    registry = make_registry(max_cells=3 * cells, max_total_cells=3 * cells)
    session = await at_its_end(registry, obey, office_log)
    await session.model.comparison.compare(MapRequest())
    before = session.model.config
    await obey(session, type="parameters", values={"resolution": 0.03})
    assert session.model.config == before
    assert session.model.comparison.explained()[0].config == before
    assert isinstance(session.limits(), Limits)
    assert session.cells == 2 * session.model.grid.log_odds.size


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("data"))) as one:
        yield one


def downloaded(service: Service, session: str) -> NDArray[np.int64]:
    """States of the map file, 0 free, 1 occupied, 2 unknown, row 0 at the smallest y."""
    image = np.asarray(Image.open(io.BytesIO(service.http.get(f"/api/sessions/{session}/map.pgm").content)))[::-1]
    return np.select([image == 254, image == 0], [0, 1], 2)


async def followed_to(watcher: Watcher, done: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    """Read until the numbers are those wanted; return them."""
    await watcher.until(
        lambda: (
            bool((watcher.newest.get("comparison") or {}).get("numbers"))
            and done(watcher.newest["comparison"]["numbers"])
        )
    )
    numbers: dict[str, Any] = watcher.newest["comparison"]["numbers"]
    return numbers


async def test_the_numbers_are_those_of_the_two_downloaded_maps(service: Service) -> None:
    sample = service.http.get("/api/logs").json()["logs"][-1]["id"]
    session = service.begin(kind="log", log=sample)
    address = f"/api/sessions/{session}/compare"
    assert service.http.get(address).json()["code"] == "compare.none"
    async with service.connect(session) as socket:
        watcher = Watcher(socket)
        await watcher.until(lambda: "parameters" in watcher.newest)
        await watcher.send("pause")
        count = watcher.newest["hello"]["log"]["n_scans"]
        await watcher.send("seek", index=count)
        await watcher.until(lambda: watcher.newest.get("frame", {"index": -1})["index"] == count)
        await watcher.settle()
        states_a, log_odds_a = downloaded(service, session), watcher.log_odds()
        kept = watcher.newest["parameters"]["values"]
        answer = service.http.put(address, json={"values": kept, "trajectory": watcher.newest["trajectory"]["name"]})
        assert answer.status_code == 200, answer.text
        assert answer.json()["max_difference"] == 0.0
        await watcher.send("parameters", values={"log_odds_hit": 0.6, "range_max": 4.0})
        numbers = await followed_to(watcher, lambda found: found["max_difference"] > 0.1)
        await watcher.settle()
        numbers = watcher.newest["comparison"]["numbers"]
        states_b, log_odds_b = downloaded(service, session), watcher.log_odds()
        told = service.http.get(address).json()
        assert {key: told[key] for key in numbers} == numbers
        # The reach is shorter, so the second map is the smaller one: lay both onto one sheet, by their origins.
        geometry_b = watcher.newest["geometry"]
        async with service.connect(session) as beside:
            second = Watcher(beside, layer="second_map")
            await second.until(lambda: second.complete)
            geometry_a = second.newest["geometry"]
            np.testing.assert_array_equal(second.log_odds(), log_odds_a)
            row, col = np.argwhere(~np.isnan(log_odds_a))[0].tolist()
            await watcher.send("inspect", row=row, col=col, epoch=geometry_a["epoch"], layer="second_map")
            cell = await watcher.answer("cell")
            assert cell["layer"] == "second_map"
            assert cell["log_odds"] == pytest.approx(log_odds_a[row, col], abs=5.5 / 254)
            await watcher.send("why", row=row, col=col, epoch=geometry_a["epoch"], layer="second_map")
            why = await watcher.answer("why")
            assert (why["layer"], why["log_odds"]) == ("second_map", cell["log_odds"])
            for touch in why["contributions"]:
                assert touch["increment"] == pytest.approx(kept["log_odds_hit" if touch["hit"] else "log_odds_miss"])
        offset = np.rint(
            (np.array(geometry_b["origin"][:2]) - np.array(geometry_a["origin"][:2])) / geometry_a["resolution"]
        ).astype(int)[::-1]
        sheet = np.full((2, *states_a.shape), 2), np.full((2, *states_a.shape), np.nan)
        part = np.s_[
            offset[0] : offset[0] + geometry_b["rows"],
            offset[1] : offset[1] + geometry_b["cols"],
        ]
        sheet[0][0], sheet[1][0] = states_a, log_odds_a
        sheet[0][1][part], sheet[1][1][part] = states_b, log_odds_b
        (a, b), (la, lb) = sheet
        table = [[int(np.sum((a == i) & (b == j))) for j in range(3)] for i in range(3)]
        assert numbers["states"] == table
        assert sum(map(sum, table)) == numbers["cells"] == a.size
        sa, sb = ~np.isnan(la), ~np.isnan(lb)
        assert numbers["only"] == [np.sum(sa & ~sb), np.sum(sb & ~sa)]
        assert numbers["both"] == np.sum(sa & sb)
        step = 5.5 / 254
        assert numbers["mean_difference"] == pytest.approx(np.abs(lb - la)[sa & sb].mean(), abs=step)
        assert numbers["max_difference"] == pytest.approx(np.abs(lb - la)[sa & sb].max(), abs=2 * step)
        for values, bits in ((la, numbers["entropy_bits"][0]), (lb, numbers["entropy_bits"][1])):
            p = 1.0 / (1.0 + np.exp(-np.nan_to_num(values)[sa | sb]))
            assert bits == pytest.approx(-np.sum(p * np.log2(p) + (1 - p) * np.log2(1 - p)), rel=0.02)
        png = np.asarray(
            Image.open(io.BytesIO(service.http.get(f"/api/sessions/{session}/compare.png").content)).convert("RGB")
        )[::-1].astype(int)
        difference = np.nan_to_num(lb - la)
        assert (png[difference > 0.5][:, 0] > png[difference > 0.5][:, 2]).all()
        assert (png[difference < -0.5][:, 0] < png[difference < -0.5][:, 2]).all()
        assert service.http.delete(address).status_code == 204
        await watcher.until(lambda: watcher.newest["comparison"]["numbers"] is None)
        assert watcher.newest["parameters"]["compare"] is None


def test_a_comparison_that_fails_gives_one_sentence(service: Service) -> None:
    sample = service.http.get("/api/logs").json()["logs"][-1]["id"]
    session, world = service.begin(kind="log", log=sample), service.begin()
    address = f"/api/sessions/{session}/compare"
    for wanted, status, code in (
        ({"log": "no such log"}, 404, "log.not_found"),
        ({"trajectory": "no such"}, 422, "log.trajectory"),
        ({"values": {"resolution": 0.0}}, 422, None),
        ({"values": 3}, 422, "request.invalid"),
        ({"unknown": 1}, 422, "request.invalid"),
    ):
        answer = service.http.put(address, json=wanted)
        assert answer.status_code == status, answer.text
        assert code in (None, answer.json()["code"]), answer.text
        assert answer.json()["message"].endswith(".")
    assert service.http.get(address).status_code == 409
    assert service.http.get(f"{address}.png").json()["code"] == "compare.none"
    assert service.http.put(f"/api/sessions/{world}/compare", json={}).json()["code"] == "session.not_a_log"
    # Another log: here the same one, as a whole, beside the first scans of the session.
    answer = service.http.put(address, json={"log": sample}).json()
    assert answer["a"]["title"]
    assert answer["only"][0] > 0
