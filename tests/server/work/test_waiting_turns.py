"""The order of waiting turns is that of a plain search among all of them."""

from __future__ import annotations

import random
from collections import Counter

import pytest

from server.work.scheduler import JobOwner, Turn, WaitingTurns


class Plain:
    """Turns that wait and run, and when addresses and owners were served: the next turn is searched for."""

    def __init__(self) -> None:
        self.waiting: list[Turn] = []
        self.running: list[Turn] = []
        self.served: dict[str | JobOwner, int] = {}

    def held(self) -> tuple[Counter[str], Counter[JobOwner]]:
        return Counter(one.owner.address for one in self.running), Counter(one.owner for one in self.running)

    def first(self, among: list[Turn]) -> Turn:
        addresses, owners = self.held()

        def order(turn: Turn) -> tuple[int, ...]:
            owner, served = turn.owner, self.served
            at_address = (addresses[owner.address], served.get(owner.address, 0))
            return (*at_address, owners[owner], served.get(owner, 0), turn.number)

        return min(among, key=order)


@pytest.mark.parametrize("seed", range(20))
def test_the_next_turn_is_that_of_a_search_among_all(seed: int) -> None:
    rng = random.Random(seed)
    owners = [JobOwner(f"visitor {n}", f"address {n % rng.randint(1, 4)}") for n in range(9)]
    slots = rng.randint(1, 4)
    plain, turns = Plain(), WaitingTurns()
    granted = 0
    for count in range(1, 600):
        match rng.choices(("request", "grant", "release", "withdraw"), (5, 4, 4, 1))[0]:
            case "request":
                turn = Turn(rng.choice(owners), interactive=True, number=count)
                served = (plain.served.get(turn.owner.address, 0), plain.served.get(turn.owner, 0))
                plain.waiting.append(turn)
                turns.add(turn, served)
            case "grant" if plain.waiting and len(plain.running) < slots:
                found = turns.first(*plain.held())
                turn = plain.first(plain.waiting)
                assert found is turn
                turns.remove(turn)
                plain.waiting.remove(turn)
                plain.running.append(turn)
                plain.served[turn.owner.address] = plain.served[turn.owner] = count
                turns.note_served(turn.owner, count)
                granted += 1
            case "release" if plain.running:
                plain.running.remove(rng.choice(plain.running))
            case "withdraw" if served_before := [one for one in plain.waiting if one.owner in plain.served]:
                turn = rng.choice(served_before)
                plain.waiting.remove(turn)
                turns.remove(turn)
        assert bool(turns) == bool(plain.waiting)
        assert all(one in turns for one in plain.waiting)
        assert {*turns.addresses()} == {one.owner.address for one in plain.waiting}
        for address in {one.address for one in owners}:
            others = [one for one in plain.waiting if one.owner.address != address]
            assert turns.first(*plain.held(), without={address}) is (plain.first(others) if others else None)
    assert granted > 50


def test_of_those_never_served_the_one_that_has_waited_longest_is_first() -> None:
    turns = WaitingTurns()
    for number, address in enumerate(("b", "a", "c"), start=1):
        turns.add(Turn(JobOwner("v", address), interactive=True, number=number), (0, 0))
    assert [turns.first_address({}), turns.first_address({"b": 1})] == ["b", "a"]
    assert turns.first_address({"a": 1, "b": 2, "c": 1}) == "a"


def test_a_turn_that_does_not_wait_cannot_be_removed() -> None:
    turns = WaitingTurns()
    turn = Turn(JobOwner("v"), interactive=True, number=1)
    with pytest.raises(ValueError, match="not in deque"):
        turns.remove(turn)
