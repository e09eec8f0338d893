"""Computations that a session leaves out for stalled clients, and the number of commands it takes of a client."""

from __future__ import annotations

import asyncio
import struct
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from mapper.core.limits import Limits
from mapper.simulation.live_map import LiveMap, world_named
from server.parts.wire import command_of
from server.sessions.computation import MAX_TICK_S
from server.sessions.host import SessionHost
from server.sessions.tick import MAX_QUEUED, MAX_QUEUED_OF_FOLLOWERS
from server.sources.simulation import SimulationModel
from server.stream.hub import STALLED_S
from server.stream.protocol import ProtocolError
from server.work.scheduler import JobOwner, Scheduler
from tests.server.service import eventually


class Clock:
    """A clock that goes on by itself only as far as the event loop's, and can be set forward."""

    def __init__(self) -> None:
        self.ahead = 0.0

    def __call__(self) -> float:
        return asyncio.get_running_loop().time() + self.ahead


async def test_nothing_is_computed_for_a_client_that_is_stalled() -> None:
    clock = Clock()
    with ThreadPoolExecutor(2) as pool:
        host = SessionHost(
            job_owner=JobOwner("v"), pool=pool, limits=lambda _: Limits(), scheduler=Scheduler(2), clock=clock
        )
        host.prepare(SimulationModel(host, LiveMap(world_named("room"), 3)))
        host.start()
        client = host.join()
        sent = [one for one in client.take() if isinstance(one, bytes)]
        await eventually(lambda: host.hub.frame_number > 3)
        seen = [host.is_seen]
        clock.ahead += STALLED_S + 1.0
        seen.append(host.is_seen)
        assert seen == [True, False]
        await eventually(lambda: not host.is_busy)
        before = host.hub.frame_number
        host.enqueue(command_of({"type": "auto", "value": False}), client)  # commands are carried out all the same
        await eventually(lambda: host.hub.frame_number > before)
        assert host.hub.frame_number == before + 1
        host.acknowledge(client, struct.unpack_from("<BBHIII", sent[-1])[4])
        await eventually(lambda: host.hub.frame_number > before + 3)
        await host.close()


async def test_questions_of_followers_do_not_refuse_the_lecturers_commands() -> None:
    with ThreadPoolExecutor(2) as pool:
        host = SessionHost(job_owner=JobOwner("v"), pool=pool, limits=lambda _: Limits(), scheduler=Scheduler(2))
        host.prepare(SimulationModel(host, LiveMap(world_named("room"), 3)))
        host.start()
        lecturer, followers = host.join(), [host.join(follows=True) for _ in range(3)]
        for client, most in ((followers, MAX_QUEUED_OF_FOLLOWERS), ([lecturer], MAX_QUEUED)):
            for k in range(most):  # the event loop carries out none of them meanwhile
                host.enqueue(command_of({"type": "inspect", "row": 1, "col": 1, "epoch": 1}), client[k % len(client)])
            with pytest.raises(ProtocolError) as caught:
                host.enqueue(command_of({"type": "inspect", "row": 1, "col": 1, "epoch": 1}), client[0])
            assert caught.value.code == "session.busy"
        await eventually(lambda: not host.has_queued_commands)
        host.enqueue(command_of({"type": "auto", "value": False}), followers[0])
        await host.close()


async def test_frames_are_rarer_while_no_client_may_be_sent_one() -> None:
    with ThreadPoolExecutor(2) as pool:
        host = SessionHost(job_owner=JobOwner("v"), pool=pool, limits=lambda _: Limits(), scheduler=Scheduler(2))
        model = SimulationModel(host, LiveMap(world_named("room"), 3))
        host.prepare(model)
        host.start()
        client = host.join()
        sent = [one for one in client.take() if isinstance(one, bytes)]
        has_room = [client.has_room]  # it is taken for slow: one frame at a time
        stamps = [model.robot_state().stamp_s]
        for _ in range(3):
            before = host.hub.frame_number
            await eventually(lambda before=before: host.hub.frame_number > before)  # type: ignore[misc]
            stamps.append(model.robot_state().stamp_s)
        # Time goes on all the same, in the longest steps.
        assert np.diff(stamps[1:]) == pytest.approx(MAX_TICK_S, abs=1e-3)
        host.acknowledge(client, struct.unpack_from("<BBHIII", sent[-1])[4])
        has_room.append(client.has_room)
        assert has_room == [False, True]
        await eventually(lambda: any(isinstance(one, bytes) for one in client.take()))
        await host.close()
