"""The results of a class as a table: counts only, nothing about who answered what."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable

from server.classes.puzzle import BINS as PUZZLE_BINS
from server.classes.puzzle import RoomPuzzle
from server.classes.questions import BINS, Question, part_of
from server.csv_text import as_text


def results_csv(questions: Iterable[Question], puzzles: Iterable[RoomPuzzle] = ()) -> str:
    """Return one line for each option, or part of the axis, of each question: RFC 4180, with a head.

    Puzzles follow: how many began, named the cause and solved it, and how many have points in each tenth of 100.
    """
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow(["question", "text", "option", "from", "to", "unit", "answers", "right"])
    for one in questions:
        for at, count in enumerate(one.counts):
            if one.axis is None:
                option, low, high, unit = (one.options or [])[at], "", "", ""
                right = one.right == at
            else:
                width = (one.axis.high - one.axis.low) / BINS
                option, unit = "", one.axis.unit
                low, high = f"{one.axis.low + at * width:.10g}", f"{one.axis.low + (at + 1) * width:.10g}"
                known_right = one.right is not None and one.axis.low <= one.right <= one.axis.high
                right = known_right and part_of(one.axis, one.right or 0.0) == at
            known = "" if one.right is None else "yes" if right else "no"
            writer.writerow([one.id, as_text(one.text), as_text(option), low, high, as_text(unit), count, known])
    for number, puzzle in enumerate(puzzles, 1):
        head, solvers = (f"puzzle {number}", as_text(puzzle.title)), puzzle.solvers.values()
        steps = {"begun": len(solvers), "cause named": sum(one.is_named for one in solvers)}
        steps["solved"] = sum(one.is_solved for one in solvers)
        writer.writerows([*head, name, "", "", "", count, ""] for name, count in steps.items())
        width = 100 // PUZZLE_BINS
        for at, count in enumerate(puzzle.counts):
            writer.writerow([*head, "", at * width, (at + 1) * width, "points", count, ""])
    return out.getvalue()
