"""Classes: a lecturer shows a page, and many followers see it on their own devices. Kept only in memory."""

from server.classes.classes import (
    ClassBudgetError,
    Classes,
    ClassNotFoundError,
    ClassRightError,
    unknown_class,
)
from server.classes.classroom import Classroom, Member
from server.classes.results import results_csv

__all__ = [
    "ClassBudgetError",
    "ClassNotFoundError",
    "ClassRightError",
    "Classes",
    "Classroom",
    "Member",
    "results_csv",
    "unknown_class",
]
