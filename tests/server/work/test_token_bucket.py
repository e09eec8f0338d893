"""A token bucket beside the closed form: after t seconds at most burst + t * rate tokens were taken."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from server.work.token_bucket import TokenBucket

PAUSES = st.lists(st.floats(0.0, 3.0), min_size=1, max_size=100)


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@given(PAUSES, st.floats(1.0, 20.0), st.floats(0.5, 20.0))
def test_never_more_than_the_burst_and_the_rate(pauses: list[float], burst: float, per_s: float) -> None:
    clock = Clock()
    bucket, taken = TokenBucket(burst, per_s, clock), 0
    for pause in pauses:
        clock.now += pause
        while bucket.try_to_spend():
            taken += 1
        assert taken <= burst + clock.now * per_s + 1e-6
        clock.now += bucket.wait_s + 1e-6
        assert bucket.try_to_spend()
        taken += 1


@given(PAUSES)
def test_who_waits_as_told_keeps_the_rate(pauses: list[float]) -> None:
    clock = Clock()
    bucket = TokenBucket(3.0, 2.0, clock)
    for number, pause in enumerate(pauses, start=1):
        clock.now += pause + bucket.spend()
        assert number <= 3.0 + 2.0 * clock.now + 1e-6


def test_late_reading_is_no_rest() -> None:
    clock = Clock()
    bucket = TokenBucket(240.0, 120.0, clock)
    while bucket.spend() == 0.0:
        pass
    for _ in range(50):
        clock.now += 0.3  # a busy service reads so late that some need no wait
        for _ in range(40):
            bucket.spend()
            assert not bucket.has_rested
    clock.now += 60.0
    assert bucket.wait_s == 0.0
    bucket.spend()
    assert bucket.has_rested
