"""The files of ``deploy/`` are read by the programs that they are for, and hold no secret and no registry."""

from __future__ import annotations

import os
import re
import subprocess
import threading
import time
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import yaml

from server.library.processing.reference_maps import LIMITS
from tests.browser.running import free_port
from tests.haproxy import CONFIGURATION, haproxy, running_haproxy
from tests.server.service import until

DEPLOY = Path(__file__).parents[1] / "deploy"


def test_haproxy_reads_its_configuration() -> None:
    program = haproxy()
    environment = os.environ | {"PORT": "8000", "REPLICAS": "localhost:8000"}
    done = subprocess.run(
        [program, "-c", "-f", CONFIGURATION], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr


def test_haproxy_waits_for_the_map_of_a_long_log() -> None:
    found = re.search(r"^ *timeout server (\d+)s$", CONFIGURATION.read_text(), re.MULTILINE)
    assert found
    assert float(found[1]) > LIMITS.timeout_s


class Stub(ThreadingHTTPServer):
    """A service that answers with its port, and late when it is asked whether it is ready."""

    daemon_threads = True

    def __init__(self) -> None:
        self.late_s, self.checks = 0.0, 0
        super().__init__(("127.0.0.1", 0), StubHandler)


class StubHandler(BaseHTTPRequestHandler):
    """The answers of a :class:`Stub`."""

    server: Stub

    def do_GET(self) -> None:
        """Answer."""
        if self.path == "/readyz":
            time.sleep(self.server.late_s)
            self.server.checks += 1
        body = str(self.server.server_address[1]).encode()
        with suppress(OSError):  # HAProxy may have given up
            self.send_response(200)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Say nothing."""


@contextmanager
def stub() -> Iterator[Stub]:
    with Stub() as service:
        thread = threading.Thread(target=service.serve_forever, args=(0.02,))
        thread.start()
        try:
            yield service
        finally:
            service.shutdown()
            thread.join()


def test_a_service_that_answers_late_keeps_its_sessions(tmp_path: Path) -> None:
    with ExitStack() as stack:
        stubs = {one.server_address[1]: one for one in (stack.enter_context(stub()), stack.enter_context(stub()))}
        address = stack.enter_context(running_haproxy(tmp_path, free_port(), list(stubs)))

        def service_of(place: str) -> int | None:
            try:
                with urllib.request.urlopen(f"{address}/api/sessions/{place}.x", timeout=60) as answer:
                    return int(answer.read())
            except OSError:
                return None

        until(lambda: service_of("ab12") is not None)
        port = service_of("ab12")
        assert port is not None
        slow = stubs[port]
        slow.late_s, checked = 1.5, slow.checks
        until(lambda: slow.checks >= checked + 3)
        assert service_of("ab12") == port


def test_every_reference_of_the_manifest_leads_somewhere() -> None:
    found = [one for one in yaml.safe_load_all((DEPLOY / "kubernetes.yaml").read_text()) if one]
    pods = [one["spec"]["template"] for one in found if one["kind"] == "Deployment"]
    labels = [pod["metadata"]["labels"] for pod in pods]
    for one in found:
        if one["kind"] == "Service":
            assert one["spec"]["selector"] in labels
        if one["kind"] == "Deployment":
            assert one["spec"]["selector"]["matchLabels"] in labels
        if one["kind"] == "NetworkPolicy":
            assert one["spec"]["podSelector"]["matchLabels"] in labels
            assert all(peer["podSelector"]["matchLabels"] in labels for peer in one["spec"]["ingress"][0]["from"])
    names = [one["metadata"]["name"] for one in found if one["kind"] == "Service"]
    values = [pair["value"] for pod in pods for pair in pod["spec"]["containers"][0]["env"]]
    assert [value for value in values if value.endswith(":8000")] == [f"{names[0]}:8000"]
    for pod in pods:
        volumes = {one["name"] for one in pod["spec"]["volumes"]}
        assert {mount["name"] for mount in pod["spec"]["containers"][0]["volumeMounts"]} == volumes


def test_the_composition_has_all_that_it_names() -> None:
    found = yaml.safe_load((DEPLOY / "compose.yaml").read_text())
    services = found["services"]
    for service in services.values():
        assert set(service.get("depends_on", ())) <= set(services)
        for volume in service.get("volumes", ()):
            source = volume.split(":")[0]
            assert (DEPLOY / source).exists() if source.startswith(".") else source in found["volumes"]
    assert services["proxy"]["environment"]["REPLICAS"] == "gridbloom:8000"
    assert (
        "postgresql://gridbloom:${POSTGRES_PASSWORD}@database/"
        in services["gridbloom"]["environment"]["GRIDBLOOM_DATABASE"]
    )


def test_nothing_is_fetched_from_a_stated_registry_and_no_secret_is_given() -> None:
    for file in DEPLOY.iterdir():
        text = file.read_text()
        for image in re.findall(r"image: (\S+)", text):
            assert "/" not in image, f"{file.name}: {image}"
        assert not re.search(r"(PASSWORD|TOKEN|SECRET_ACCESS_KEY): [^$\s]", text), file.name
