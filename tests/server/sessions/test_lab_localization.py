"""The lab localizes its robot: found without a hint, kidnapped by a click, found again."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.simulation import WORLDS
from mapper.simulation.live_map import LiveMap
from server.parts.localization.live import MOST_SHOWN, LabLocalization
from server.parts.wire import command_of
from server.sessions import SessionRegistry
from server.sessions.tick import TickResult
from server.sources.simulation import SimulationModel
from server.stream.protocol import ProtocolError
from tests.server.begin import new_simulation
from tests.server.sent import sent, sent_one

FEW = {"global_particles": 4000}


def lab_localization(mapper: LiveMap, values: dict[str, Any]) -> LabLocalization:
    simulation = mapper.simulation
    return LabLocalization(simulation.world, simulation.sensor, simulation.mount, mapper.newest_pose, values)


def drive(mapper: LiveMap, one: LabLocalization, seconds: float) -> dict[str, Any]:
    for _ in range(int(4 * seconds)):
        mapper.advance(0.25)
        assert mapper.newest is not None
        one.look(mapper.newest, mapper.newest_pose)
    return sent_one(one.message())


def test_the_robot_is_found_kidnapped_and_found_again() -> None:
    mapper = LiveMap(WORLDS["office"], seed=2)
    one = lab_localization(mapper, FEW)
    assert not sent_one(one.message())["is_converged"]
    wide = sent_one(one.message())["entropy"]
    found = drive(mapper, one, 25.0)
    assert found["is_converged"]
    assert found["error_m"] < 0.4
    assert found["entropy"] < wide - 3.0
    mapper.teleport(16.5, 3.0, 1.0)
    one.note_teleport(mapper.newest_pose)
    assert mapper.newest is not None
    one.look(mapper.newest, mapper.newest_pose)
    assert sent_one(one.message())["error_m"] > 5.0  # it was not told
    for _ in range(60):
        found = drive(mapper, one, 2.0)
        if found["is_converged"] and found["error_m"] < 0.4:
            break
    assert found["error_m"] < 0.4
    assert found["error_rad"] < 0.3


def test_of_many_particles_some_are_sent() -> None:
    one = lab_localization(LiveMap(WORLDS["room"], seed=1), {"global_particles": 25_000})
    particles, field = one.layers
    particles.publish()
    count, parts = particles.body  # type: ignore[attr-defined]
    assert MOST_SHOWN / 2 < count <= MOST_SHOWN
    table = np.frombuffer(b"".join(parts), dtype=np.float32)
    assert len(table) >= 4 * count
    assert (field.name, field.kind) == ("likelihood_field", "grid")


def test_it_is_given_another_map_than_the_plan() -> None:
    mapper = LiveMap(WORLDS["room"], seed=2)
    simulation = mapper.simulation
    errors, fits = {}, {}
    for given in ("plan", "moved", "other"):
        mapper = LiveMap(WORLDS["room"], seed=2)
        one = LabLocalization(simulation.world, simulation.sensor, simulation.mount, mapper.newest_pose, FEW, given)
        seen = [drive(mapper, one, 2.0) for _ in range(7)]
        assert seen[-1]["map"] == given
        errors[given], fits[given] = (float(np.median([found[key] for found in seen])) for key in ("error_m", "fit"))
    # Tables that stand elsewhere pull the robot towards them, by less than a table's width.
    assert errors["plan"] < 0.3
    assert errors["moved"] < 1.2 < errors["other"]
    assert fits["plan"] > fits["moved"] + 0.05
    with pytest.raises(ConfigError, match="plan, moved, other"):
        LabLocalization(simulation.world, simulation.sensor, simulation.mount, mapper.newest_pose, FEW, "none")


def test_two_equal_rooms_explain_the_first_scan_alike() -> None:
    mapper = LiveMap(WORLDS["twins"], seed=2)
    one = lab_localization(mapper, {"global_particles": 20_000})
    drive(mapper, one, 0.5)
    particles, _ = one.layers
    particles.publish()
    x = np.frombuffer(b"".join(particles.body[1]), dtype=np.float32)[: particles.body[0]]  # type: ignore[attr-defined]
    here, x_true = np.abs(x - mapper.newest_pose[0]) < 1.0, mapper.newest_pose[0]
    there = np.abs(x - x_true - 7.86) < 1.0
    assert here.mean() > 0.1
    assert there.mean() > 0.1


def message_of(model: SimulationModel) -> dict[str, Any]:
    return next(one for one in sent(model.messages()) if one["type"] == "localization")


async def test_a_session_begins_and_ends_it(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "room", 3, playing=False)
    model: SimulationModel = session.model
    async with session.locked():
        result = TickResult()
        model.handle(command_of({"type": "localize", "value": True, "values": {"global_particles": 500}}), result)
        assert [layer.name for layer in model.layers] == ["map", "particles", "likelihood_field"]
        before = model.footprint.cells
        message = message_of(model)
        assert message["is_on"]
        assert message["values"] == {"global_particles": 500}
        for values in ({"sigma_hit": -1.0}, {"speed": 1.0}):
            with pytest.raises(ConfigError):
                model.handle(command_of({"type": "localize", "value": True, "values": values}), result)
        with pytest.raises(ProtocolError):
            model.handle(command_of({"type": "localize", "value": True, "values": 3}), result)
        assert message_of(model) == message  # what was refused changed nothing
        model.handle(command_of({"type": "teleport", "x": 8.0, "y": 6.0}), result)
        model.draw(result)
        assert message_of(model)["error_m"] > 0.5
        model.handle(command_of({"type": "localize", "value": False}), result)
        assert [layer.name for layer in model.layers] == ["map"]
        assert not message_of(model)["is_on"]
        assert model.footprint.cells < before


async def test_another_world_ends_it(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "room", 3, playing=False)
    model: SimulationModel = session.model
    async with session.locked():
        result = TickResult()
        model.handle(command_of({"type": "localize", "value": True, "values": FEW}), result)
        model.handle(command_of({"type": "world", "name": "maze"}), result)
        assert len(model.layers) == 1


def test_a_running_filter_goes_on_with_other_parameters() -> None:
    mapper = LiveMap(WORLDS["room"], seed=2)
    one = lab_localization(mapper, FEW)
    before = drive(mapper, one, 6.0)
    particles, field = one.layers
    field.publish()
    one.change(FEW | {"sigma_hit": 0.03, "laser_likelihood_max_dist": 0.5})
    after = sent_one(one.message())
    assert after["values"]["sigma_hit"] == 0.03
    assert (after["n_updates"], after["n_particles"]) == (before["n_updates"], before["n_particles"])
    # The colours tell how the newest scan weighs the particles by the new model: not all alike.
    particles.publish()
    count, parts = particles.body  # type: ignore[attr-defined]
    value = np.frombuffer(b"".join(parts), dtype=np.float32)[-count:]
    assert value.max() == 1.0
    assert value.min() < 0.5
    with pytest.raises(ConfigError):
        one.change({"sigma_hit": -1.0})
    assert sent_one(one.message())["values"]["sigma_hit"] == 0.03
