"""What only cycles of references hold is freed, sooner or later."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator

import pytest

from server.work.memory import give_back


class Cyclic:
    """An object that refers to itself."""

    def __init__(self) -> None:
        self.own = self


@pytest.fixture(autouse=True)
def collector() -> Iterator[None]:
    """Have the collector look through all objects again after the test."""
    yield
    gc.unfreeze()


@pytest.mark.parametrize("is_idle", [False, True])
def test_what_refers_to_itself_is_freed(is_idle: bool) -> None:
    seen = weakref.ref(Cyclic())
    give_back(is_idle=is_idle)
    assert seen() is None


def test_what_was_left_out_while_it_was_used_is_freed_once_the_service_is_idle() -> None:
    used = Cyclic()
    seen = weakref.ref(used)
    give_back(is_idle=True)
    assert gc.get_freeze_count() > 0
    del used
    give_back(is_idle=False)
    assert seen() is not None
    give_back(is_idle=True)
    assert seen() is None
