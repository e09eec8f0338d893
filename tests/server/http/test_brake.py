"""The brake on guesses, with a clock of the test's own."""

from __future__ import annotations

from server.http.brake import MAX_NETWORKS, Brake


def test_a_burst_is_allowed_and_then_one_guess_at_each_interval() -> None:
    now = 100.0
    brake = Brake(burst=3, per_minute=6.0, clock=lambda: now)
    for _ in range(3):
        assert brake.wait_s("192.0.2.1") == 0.0
        brake.count("192.0.2.1")
    assert brake.wait_s("192.0.2.1") == 10.0
    assert brake.wait_s("192.0.2.2") == 0.0
    now += 10.0
    assert brake.wait_s("192.0.2.1") == 0.0
    brake.count("192.0.2.1")
    assert brake.wait_s("192.0.2.1") == 10.0
    now += 1000.0
    assert brake.wait_s("192.0.2.1") == 0.0


def test_addresses_of_one_ipv6_network_count_together() -> None:
    brake = Brake(burst=1, per_minute=1.0, clock=lambda: 0.0)
    brake.count("2001:db8::1")
    assert brake.wait_s("2001:db8::2") > 0.0
    assert brake.wait_s("2001:db8:0:1::2") == 0.0


def test_the_number_of_recorded_networks_is_bounded() -> None:
    brake = Brake(burst=1, per_minute=1.0, clock=lambda: 0.0)
    for i in range(MAX_NETWORKS + 1):
        brake.count(f"10.{i >> 16}.{i >> 8 & 255}.{i & 255}")
    assert brake.wait_s("10.0.0.0") == 0.0
    assert brake.wait_s("10.0.0.1") > 0.0
