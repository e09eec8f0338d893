"""The brake on guesses, with a clock of the test's own."""

from __future__ import annotations

from pathlib import Path

import pytest

from server.http.brake import Brake
from server.workers.shared import MAX_NETWORKS
from tests.server.service import running, settings_for


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


@pytest.mark.parametrize("proxies", [("127.0.0.1",), ()])
def test_wrong_tokens_count_for_the_client_that_a_trusted_proxy_names(tmp_path: Path, proxies: tuple[str, ...]) -> None:
    with running(settings_for(tmp_path, token="long enough", trusted_proxies=proxies)) as service:

        def guess(address: str) -> int:
            headers = {"X-Forwarded-For": address, "Authorization": "Bearer wrong"}
            return service.http.get("/api/sessions", headers=headers).status_code

        assert {guess("198.51.100.7") for _ in range(60)} == {401, 429}
        assert guess("198.51.100.8") == (401 if proxies else 429)


def test_a_proxy_that_is_no_address_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no IP address"):
        settings_for(tmp_path, trusted_proxies=("proxy.example.org",))
