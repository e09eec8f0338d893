"""The messages of a class between the lecturer's page, the service, and the pages of the followers.

Each is defined once, like those of :mod:`server.stream.messages`. They are sent over `/api/classes/{code}/stream`.
"""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct

from server.stream.message_parts import Number, Point, Whole
from server.stream.messages import WhyMessage

MAX_OPTIONS = 8
MAX_TEXT = 300
MAX_HASH = 20_000  #: of an address; that of an older page may contain a slide deck, which no follower receives
MAX_SLIDE_TEXT = 4000
Sentence = Annotated[str, Meta(max_length=MAX_TEXT)]
Name = Annotated[str, Meta(max_length=100)]
Sentences = Annotated[list[Sentence], Meta(max_length=MAX_OPTIONS)]
Hash = Annotated[str, Meta(max_length=MAX_HASH)]


class ClassLook(Struct):
    """The part of the map shown in a picture, with the size of the picture."""

    x: Annotated[Number, Meta(description="the place in the middle, m")]
    y: Annotated[Number, Meta(description="the place in the middle, m")]
    scale: Annotated[float, Meta(description="metres that a pixel shows", gt=0.0, le=1e6)]
    width: Annotated[float, Meta(description="width of the picture, pixels", gt=0.0, le=1e6)]
    height: Annotated[float, Meta(description="height of the picture, pixels", gt=0.0, le=1e6)]


class ClassSlide(Struct):
    """The current slide without its notes, the only part of the lecturer's deck that followers receive."""

    kind: Annotated[
        Literal["title", "section", "derivation", "text", "lab", "log"],
        Meta(
            description="the title with a map, a section of the lecture, its derivation, a text of the lecturer's, or "
            "a page in the slide"
        ),
    ]
    section: Annotated[Name | None, Meta(description="name of the section; null for other kinds")] = None
    title: Annotated[Sentence | None, Meta(description="title; null for a section")] = None
    text: Annotated[
        Annotated[str, Meta(max_length=MAX_SLIDE_TEXT)] | None,
        Meta(description="the paragraphs of a text that are shown so far; of a section, its answer once it is shown"),
    ] = None
    address: Annotated[
        Hash | None,
        Meta(description="address of a shared view in the slide; null for pages that only the lecturer may open"),
    ] = None


class ClassView(Struct):
    """State of the lecturer's page. Places are map metres."""

    page: Annotated[
        Literal["lecture", "lab", "logs", "other"],
        Meta(description="the page; logs: the map of a log; other: no page that can be followed"),
    ]
    hash: Annotated[Hash, Meta(description="fragment of its address: section, or slide and step")] = ""
    slide: Annotated[ClassSlide | None, Meta(description="the slide that is shown; null: none")] = None
    blank: Annotated[bool, Meta(description="whether the screen is blank")] = False
    look: Annotated[ClassLook | None, Meta(description="the visible part of the map; null: all of it")] = None
    pointer: Annotated[Point | None, Meta(description="where the pointer is in the map")] = None
    pinned: Annotated[Point | None, Meta(description="the selected cell")] = None
    explained: Annotated[Point | None, Meta(description="the cell whose updates are explained")] = None
    update: Annotated[Whole | None, Meta(description="number of the selected update; null: the newest")] = None
    group: Annotated[Name | None, Meta(description="the open group of controls")] = None
    on_slide: Annotated[
        tuple[float, float] | None,
        Meta(description="where the pointer is on the slide, as fractions of its width and height"),
    ] = None


class ClassAxis(Struct):
    """The axis for guessing a number."""

    low: Annotated[Number, Meta(description="least guess")]
    high: Annotated[Number, Meta(description="greatest guess")]
    unit: Annotated[Name, Meta(description="unit, may be empty")] = ""


class ClassQuestion(Struct):
    """A question for the class, and the answers to it."""

    id: Annotated[int, Meta(description="number of the question, from 1")]
    text: Annotated[str, Meta(description="the question")]
    options: Annotated[list[str] | None, Meta(description="the answers to choose from; null: a number is guessed")]
    axis: Annotated[ClassAxis | None, Meta(description="the axis of the guess; null: an option is chosen")]
    is_revealed: Annotated[bool, Meta(description="whether the result is shown to all")]
    is_closed: Annotated[bool, Meta(description="whether no more answers are taken; always so once it is revealed")]
    answered: Annotated[int, Meta(description="how many answers are counted")]
    counts: Annotated[
        list[int] | None,
        Meta(description="answers for each option, or in each part of the axis; followers: null before the reveal"),
    ]
    right: Annotated[
        float | None, Meta(description="the right option from 0, or number; null: there is none, or not yet")
    ]
    last_number: Annotated[
        int | None, Meta(description="answers of followers up to this number are counted; null: of all")
    ] = None


class ClassSolver(Struct):
    """Progress of one follower with the puzzle; followers are known by number only."""

    number: Annotated[int, Meta(description="number of the follower")]
    is_named: Annotated[bool, Meta(description="whether the cause is named")]
    repair: Annotated[float, Meta(description="share of the repair, 0 to 1")]
    is_solved: Annotated[bool, Meta(description="whether the puzzle is solved")]
    points: Annotated[int, Meta(description="points, 0 to 100")]


class ClassPuzzle(Struct):
    """The puzzle that the class solves."""

    title: Annotated[str, Meta(description="its title")]
    begun: Annotated[int, Meta(description="how many have begun")]
    solved: Annotated[int, Meta(description="how many have solved it")]
    board: Annotated[list[ClassSolver], Meta(description="how far each is; lecturer only, for others empty")]


class ClassState(Struct, tag_field="type", tag="class"):
    """The state of the class, sent to all its members, at most five times a second."""

    code: Annotated[str, Meta(description="the code of the class")]
    present: Annotated[int, Meta(description="followers that are connected")]
    is_locked: Annotated[bool, Meta(description="whether no one else can join")]
    has_ended: Annotated[bool, Meta(description="whether the class is over")]
    hands: Annotated[list[int], Meta(description="numbers of the followers who ask for the robot; lecturer only")]
    driver: Annotated[int | None, Meta(description="number of the follower who drives the robot; null: the lecturer")]
    question: Annotated[ClassQuestion | None, Meta(description="the question that is asked; null: none")]
    puzzle: Annotated[ClassPuzzle | None, Meta(description="the puzzle that is solved; null: none")] = None
    is_lecturer_away: Annotated[bool, Meta(description="whether no page of the lecturer's is connected")] = False
    counts_joined_only: Annotated[
        bool, Meta(description="whether answers are counted only of who had joined when the question was asked")
    ] = False


class ClassWelcome(Struct, tag_field="type", tag="welcome"):
    """The first message: the role of the receiver in the class."""

    role: Annotated[Literal["lecturer", "follower"], Meta(description="what one may do")]
    number: Annotated[int, Meta(description="number of a follower, from 1; 0: the lecturer")]
    answer: Annotated[float | None, Meta(description="what one has answered to the question; null: nothing")]


class ClassViewMessage(Struct, tag_field="type", tag="view"):
    """Current state of the lecturer's page, sent to the followers."""

    view: Annotated[ClassView, Meta(description="what the lecturer shows")]
    stage: Annotated[int, Meta(description="number of the session that is shown, from 1; 0: none")]


class ClassExplained(Struct, tag_field="type", tag="explained"):
    """The explanation of the selected cell, as shown on the lecturer's page, sent to the followers."""

    why: Annotated[WhyMessage | None, Meta(description="the explanation; null: none is shown")]


class ClassError(Struct, tag_field="type", tag="refused"):
    """A command was refused."""

    code: Annotated[str, Meta(description="stable name of the error")]
    message: Annotated[str, Meta(description="one sentence")]
    answer: Annotated[
        float | None, Meta(description="of an answer to the question that is asked: the one that is counted")
    ] = None


ClassMessage = ClassState | ClassWelcome | ClassViewMessage | ClassExplained | ClassError


class ShowCommand(Struct, tag_field="type", tag="show"):
    """Lecturer: the current state of the page."""

    view: Annotated[ClassView, Meta(description="what it shows")]
    session: Annotated[Name | None, Meta(description="id of the session that it shows; null: none")] = None


class ExplainCommand(Struct, tag_field="type", tag="explain"):
    """Lecturer: the explanation shown on the page."""

    why: Annotated[WhyMessage | None, Meta(description="the explanation; null: none is shown")] = None


class AskCommand(Struct, tag_field="type", tag="ask"):
    """Lecturer: ask the class a question, with options to choose from or an axis for guessing a number."""

    text: Annotated[Sentence, Meta(description="the question")]
    options: Annotated[Sentences | None, Meta(description="two to eight answers; null: a number is guessed")] = None
    axis: Annotated[ClassAxis | None, Meta(description="the axis of the guess")] = None
    right: Annotated[Number | None, Meta(description="the right option from 0, or number; null: there is none")] = None


class RevealCommand(Struct, tag_field="type", tag="reveal"):
    """Lecturer: show the result to all. No more answers are accepted."""

    right: Annotated[Number | None, Meta(description="the right answer, if it was not known before")] = None


class StopCommand(Struct, tag_field="type", tag="stop"):
    """Lecturer: accept no more answers to the question, or accept them again. Its result is not shown yet."""

    value: Annotated[bool, Meta(description="false: answers are taken again, and those given are kept")] = True


class CloseCommand(Struct, tag_field="type", tag="close"):
    """Lecturer: remove the question. Its result is kept until the class ends."""


class LockCommand(Struct, tag_field="type", tag="lock"):
    """Lecturer: close the class to new listeners, or open it again."""

    value: Annotated[bool, Meta(description="whether it is locked")]


class CountCommand(Struct, tag_field="type", tag="count"):
    """Lecturer: choose whose answers are counted, for all questions of the class."""

    joined_only: Annotated[bool, Meta(description="only of who had joined when the question was asked")]


class HandCommand(Struct, tag_field="type", tag="hand"):
    """Lecturer: hand the robot to a follower, or take it back."""

    number: Annotated[Whole | None, Meta(description="number of the follower; null: take it back")] = None


class AnswerCommand(Struct, tag_field="type", tag="answer"):
    """Follower: answer the question; a later answer replaces it."""

    question: Annotated[Whole, Meta(description="id of the question")]
    value: Annotated[Number, Meta(description="the option from 0, or the number")]


class RaiseCommand(Struct, tag_field="type", tag="raise"):
    """Follower: request the robot, or withdraw the request."""

    value: Annotated[bool, Meta(description="whether one asks for it")]


ClassCommand = (
    ShowCommand
    | ExplainCommand
    | AskCommand
    | RevealCommand
    | StopCommand
    | CloseCommand
    | LockCommand
    | CountCommand
    | HandCommand
    | AnswerCommand
    | RaiseCommand
)
