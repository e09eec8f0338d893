"""A class without sockets: the limits of its members and questions, and the table of results."""

from __future__ import annotations

import asyncio
import csv
import io
import sys
from typing import Literal

import pytest

from mapper.core.errors import ConfigError
from server.classes import ClassBudgetError, Classes, ClassNotFoundError, Classroom, classes, classroom, results_csv
from server.classes.classes import PreparedHere
from server.stream.class_messages import AnswerCommand, AskCommand, ClassAxis, ClassView, RevealCommand, ShowCommand

Page = Literal["lecture", "lab", "logs", "other"]


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
    with pytest.raises(ClassBudgetError, match="This class is full"):
        every.join(code, "third")
    assert every.join(code, "second")[1].number == member.number


async def test_one_address_takes_part_of_the_places_and_those_who_come_back_take_none_of_the_others() -> None:
    every = Classes(max_followers=8)
    code = every.open("lecturer").code
    first = [every.join(code, f"hall {i}", "hall")[1] for i in range(6)]  # three quarters
    with pytest.raises(ClassBudgetError, match="Another network") as caught:
        every.join(code, "hall 6", "hall")
    assert caught.value.code == "class.crowded_address"
    every.join(code, "hall 5", "hall")  # a second page of one who is there
    every.get(code).leave(first[0])
    every.join(code, "hall 6", "hall")
    every.join(code, "hall 0", "hall")  # who has joined before can come back, as a seventh
    assert every.get(code).present == 7
    every.join(code, "at home", "elsewhere")
    every.join(code, "abroad", "far away")
    with pytest.raises(ClassBudgetError, match="This class is full") as caught:
        every.join(code, "another", "a fourth")
    assert caught.value.code == "class.crowded"


async def test_who_drops_the_cookie_at_one_address_leaves_numbers_for_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(classes, "MAX_NUMBERS", 4)
    every = Classes(max_followers=8)
    code = every.open("lecturer").code
    for i in range(3):
        room, member = every.join(code, f"cookie {i}", "one")
        room.leave(member)
    with pytest.raises(ClassBudgetError) as caught:
        every.join(code, "cookie 3", "one")
    assert caught.value.code == "class.crowded_address"
    assert every.join(code, "somebody", "another")[1].number == 4


async def test_one_address_has_so_many_connections_to_the_session_that_is_shown() -> None:
    every = Classes(max_followers=2)
    room = every.open("lecturer")
    with every.watching(room, "one"), every.watching(room, "one"):
        with pytest.raises(ClassBudgetError, match="Another network"), every.watching(room, "one"):
            pass
        with every.watching(room, "another"):
            pass
    with every.watching(room, "one"):
        pass


@pytest.mark.parametrize(
    ("asked_on", "same", "another"),
    [
        (
            ("lecture", "?present#cell/2&deck=a-b"),
            ("lecture", "?present#cell/4&deck=a-b"),
            ("lecture", "?present#grid"),
        ),
        (("lecture", "?present#cell/2"), ("lecture", "?present#cell"), ("lab", "")),
        (("lecture", "#cell"), ("lecture", "#grid"), ("lecture", "?present#grid")),
        (("lab", ""), ("lab", ""), ("logs", "")),
    ],
)
async def test_a_revealed_question_is_closed_when_another_slide_or_page_is_shown(
    asked_on: tuple[Page, str], same: tuple[Page, str], another: tuple[Page, str]
) -> None:
    room = Classroom("BCDFGH", "lecturer")
    teacher = room.join("lecturer")

    def asked_after_showing(*view: tuple[Page, str]) -> bool:
        for page, fragment in view:
            room.handle(teacher, ShowCommand(ClassView(page, fragment)))
        return room.asked is not None

    assert not asked_after_showing(asked_on)
    room.handle(teacher, AskCommand("Which?", options=["a", "b"]))
    assert asked_after_showing(another, asked_on)  # it can still be answered
    room.handle(teacher, RevealCommand())
    assert asked_after_showing(same)
    assert not asked_after_showing(another)
    assert len(room.questions) == 1  # of the results
    # revealed where another page is shown already, it stays there
    room.handle(teacher, AskCommand("Which?", options=["a", "b"]))
    assert asked_after_showing(asked_on)
    room.handle(teacher, RevealCommand())
    assert asked_after_showing(same, another, same)
    assert not asked_after_showing(("other", ""))


async def test_a_guess_has_an_axis_of_a_usable_width() -> None:
    room = Classroom("BCDFGH", "lecturer")
    teacher, pupil = room.join("lecturer"), room.join("follower")
    most = sys.float_info.max
    for low, high in ((-most, most), (0.0, 5e-324)):
        with pytest.raises(ConfigError) as caught:
            room.handle(teacher, AskCommand("How far?", axis=ClassAxis(low, high, "m")))
        assert caught.value.code == "class.axis"
    room.handle(teacher, AskCommand("How far?", axis=ClassAxis(10_000.0, 10_001.0, "m"), right=10_000.13))
    room.handle(pupil, AnswerCommand(1, 10_000.13))
    room.handle(teacher, RevealCommand())
    rows = [*csv.DictReader(io.StringIO(results_csv(room.questions)))]
    assert [row["from"] for row in rows if row["answers"] == "1"] == ["10000.1"]
    assert [row["answers"] for row in rows if row["right"] == "yes"] == ["1"]


async def test_a_class_ends_some_time_after_its_lecturer_left_without_anybody_asking(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = 0.0
    every = Classes(max_followers=9, prepared=PreparedHere("BCDFGH"), clock=lambda: now)
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
