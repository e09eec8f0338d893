"""The questions of a class and their answers."""

from __future__ import annotations

from dataclasses import dataclass, field

from mapper.core.errors import ConfigError
from server.stream.class_messages import AskCommand, ClassAxis, ClassQuestion

BINS = 20  #: number of parts of a guess's axis for counting answers
LEAST_WIDTH, GREATEST_WIDTH = 1e-12, 1e15  #: of the axis of a guess


def part_of(axis: ClassAxis, value: float) -> int:
    """Return the index of the part of an axis that contains a guess; the last part includes its end."""
    return min(BINS - 1, int((value - axis.low) / ((axis.high - axis.low) / BINS)))


@dataclass(slots=True)
class Question:
    """A question and its answers, by the number of the follower.

    ``newest`` is the greatest number of a follower when it was asked. Numbers increase, so with ``joined_only`` only
    answers up to it are counted, and joining again under another identity gives no second answer.

    Raises :class:`ConfigError` for an invalid question.
    """

    id: int
    text: str
    options: list[str] | None
    axis: ClassAxis | None
    right: float | None = None
    is_revealed: bool = False
    is_closed: bool = False  #: whether answers are no longer accepted
    answers: dict[int, float] = field(default_factory=dict)
    newest: int = 0
    joined_only: bool = False

    @classmethod
    def of(cls, number: int, asked: AskCommand, newest: int = 0, *, joined_only: bool = False) -> Question:
        """Return the question of a command."""
        options = None if asked.options is None else [option.strip() for option in asked.options]
        if not asked.text.strip():
            raise ConfigError("class.question", "A question needs a text.")
        if (options is None) == (asked.axis is None):
            raise ConfigError("class.question", "A question has either options or an axis.")
        if options is not None and (len(options) < 2 or not all(options)):
            raise ConfigError("class.options", "A question needs at least two options, none of them empty.")
        if asked.axis is not None and not asked.axis.low < asked.axis.high:
            raise ConfigError("class.axis", "The lowest guess must be below the highest.")
        if asked.axis is not None and not LEAST_WIDTH <= asked.axis.high - asked.axis.low <= GREATEST_WIDTH:
            # On a wider or narrower axis the width of a part is not representable.
            raise ConfigError("class.axis", f"Guesses may be {LEAST_WIDTH:g} to {GREATEST_WIDTH:g} apart.")
        question = cls(number, asked.text.strip(), options, asked.axis, newest=newest, joined_only=joined_only)
        question.set_right(asked.right)
        return question

    def set_right(self, right: float | None) -> None:
        """Set the right answer. Raises :class:`ConfigError` for an unknown option."""
        if right is not None and self.options is not None and right not in range(len(self.options)):
            raise ConfigError("class.right", "The right answer is not one of the options.")
        self.right = self.right if right is None else right

    def answer(self, follower: int, value: float) -> None:
        """Record an answer, which replaces an earlier one. Raises :class:`ConfigError` if it is invalid."""
        if self.is_closed:
            raise ConfigError("class.closed", "Voting is closed: your answer came too late.")
        if self.options is not None and value not in range(len(self.options)):
            raise ConfigError("class.answer", "That is not one of the options.")
        if self.axis is not None and not self.axis.low <= value <= self.axis.high:
            raise ConfigError("class.answer", f"A guess must be between {self.axis.low:g} and {self.axis.high:g}.")
        self.answers[follower] = value

    def stop(self, value: bool) -> None:
        """Stop accepting answers, or accept them again. Raises :class:`ConfigError` once the result is shown."""
        if self.is_revealed and not value:
            raise ConfigError("class.revealed", "The result is shown: no more answers can be taken.")
        self.is_closed = value

    def reveal(self, right: float | None) -> None:
        """Show the result to all. Raises :class:`ConfigError` for an unknown option."""
        self.set_right(right)
        self.is_revealed = self.is_closed = True

    @property
    def counted(self) -> list[float]:
        """The counted answers, one for each number."""
        return [value for number, value in self.answers.items() if not self.joined_only or number <= self.newest]

    @property
    def counts(self) -> list[int]:
        """The number of answers for each option, or in each of :data:`BINS` equal parts of the axis."""
        if self.axis is None:
            counts = [0] * len(self.options or ())
            for value in self.counted:
                counts[int(value)] += 1
            return counts
        counts = [0] * BINS
        for value in self.counted:
            counts[part_of(self.axis, value)] += 1
        return counts

    def message(self, *, lecturer: bool) -> ClassQuestion:
        """Return the question as seen by the lecturer or a follower."""
        shown = lecturer or self.is_revealed
        return ClassQuestion(
            self.id,
            self.text,
            self.options,
            self.axis,
            self.is_revealed,
            self.is_closed,
            len(self.counted),
            self.counts if shown else None,
            self.right if shown else None,
            self.newest if self.joined_only else None,
        )
