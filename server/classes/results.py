"""The results of a class as a table. It contains only counts, not who answered what."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable

from server.classes.classroom import BINS as PUZZLE_BINS
from server.classes.classroom import RoomPuzzle
from server.classes.questions import BINS, Question, part_of
from server.csv_text import as_text


def results_csv(questions: Iterable[Question], puzzles: Iterable[RoomPuzzle] = ()) -> str:
    """Return one line for each option, or part of the axis, of each question: RFC 4180, with a header.

    Puzzles follow: how many followers began, named the cause and solved it, and how many have points in each tenth of
    100.
    """
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow(["question", "text", "option", "from", "to", "unit", "answers", "right"])
    for question in questions:
        for at, count in enumerate(question.counts):
            if question.axis is None:
                option, low, high, unit = (question.options or [])[at], "", "", ""
                right = question.right == at
            else:
                width = (question.axis.high - question.axis.low) / BINS
                option, unit = "", question.axis.unit
                low, high = f"{question.axis.low + at * width:.10g}", f"{question.axis.low + (at + 1) * width:.10g}"
                known_right = question.right is not None and question.axis.low <= question.right <= question.axis.high
                right = known_right and part_of(question.axis, question.right or 0.0) == at
            known = "" if question.right is None else "yes" if right else "no"
            writer.writerow(
                [question.id, as_text(question.text), as_text(option), low, high, as_text(unit), count, known]
            )
    for number, puzzle in enumerate(puzzles, 1):
        head, solvers = (f"puzzle {number}", as_text(puzzle.title)), puzzle.solvers.values()
        steps = {"begun": len(solvers), "cause named": sum(solver.is_named for solver in solvers)}
        steps["solved"] = sum(solver.is_solved for solver in solvers)
        writer.writerows([*head, name, "", "", "", count, ""] for name, count in steps.items())
        width = 100 // PUZZLE_BINS
        for at, count in enumerate(puzzle.counts):
            writer.writerow([*head, "", at * width, (at + 1) * width, "points", count, ""])
    return out.getvalue()
