"""A class without sockets: the limits of its members and questions, and the table of results."""

from __future__ import annotations

import asyncio
import csv
import io
import sys

import pytest

from mapper.core.errors import ConfigError
from server.classes import ClassBudgetError, Classes, ClassNotFoundError, Classroom, classes, classroom, results_csv
from server.stream.class_messages import AnswerCommand, AskCommand, ClassAxis, RevealCommand


async def test_one_visitor_has_few_connections_and_a_class_few_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    every = Classes(max_followers=400)
    code = every.open("lecturer").code
    for visitor in ("lecturer", "follower"):
        joined = [every.join(code, visitor)[1] for _ in range(classes.MAX_CONNECTIONS)]
        with pytest.raises(ClassBudgetError) as caught:
            every.join(code, visitor)
        assert caught.value.code == "class.connections"
        every.get(code).leave(joined[0])
        every.join(code, visitor)
    with pytest.raises(ClassBudgetError):  # the lecturer's pages that follow are counted with the others
        every.join(code, "lecturer", follows=True)
    monkeypatch.setattr(classroom, "MAX_NUMBERS", 2)
    room, member = every.join(code, "second")
    room.leave(member)
    with pytest.raises(ClassBudgetError, match="As many people"):
        every.join(code, "third")
    assert every.join(code, "second")[1].number == member.number


async def test_a_guess_has_an_axis_of_a_usable_width() -> None:
    room = Classroom("BCDFGH", "lecturer")
    teacher, pupil = room.join("lecturer"), room.join("follower")
    most = sys.float_info.max
    for low, high in ((-most, most), (0.0, 5e-324)):
        with pytest.raises(ConfigError) as caught:
            room.obey(teacher, AskCommand("How far?", axis=ClassAxis(low, high, "m")))
        assert caught.value.code == "class.axis"
    room.obey(teacher, AskCommand("How far?", axis=ClassAxis(10_000.0, 10_001.0, "m"), right=10_000.13))
    room.obey(pupil, AnswerCommand(1, 10_000.13))
    room.obey(teacher, RevealCommand())
    rows = [*csv.DictReader(io.StringIO(results_csv(room.questions)))]
    assert [row["from"] for row in rows if row["answers"] == "1"] == ["10000.1"]
    assert [row["answers"] for row in rows if row["right"] == "yes"] == ["1"]


async def test_a_class_ends_some_time_after_its_lecturer_left_without_anybody_asking(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = 0.0
    every = Classes(max_followers=9, prepared="BCDFGH", clock=lambda: now)
    room = every.open("lecturer")
    member = room.join("lecturer")
    monkeypatch.setattr(classes, "LOOK_EVERY_S", 0.0)
    watching = asyncio.create_task(every.watch())
    now += 2 * classes.LONGEST_ABSENCE_S
    for _ in range(5):
        await asyncio.sleep(0)
    assert every.get("BCDFGH") is room  # the lecturer is there
    room.leave(member)
    now += classes.LONGEST_ABSENCE_S + 1.0
    for _ in range(5):
        await asyncio.sleep(0)
    watching.cancel()
    assert room.has_ended
    with pytest.raises(ClassNotFoundError):
        every.get("BCDFGH")
