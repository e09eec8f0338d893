"""The container image: built by Buildah on a Debian made by debootstrap, run, and used by a client.

Buildah's chroot isolation needs no daemon and no namespaces, only root. Registries of packages are reached as the
machine is set up to reach them: its settings of pip and npm, and its certificates, are in the base.
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest

from mapper.io.export import GrowingMap, write_mcap
from mapper.mapping.integrate import grid_for
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import sample_log
from server.client import Client
from tests.programs import apt_install
from tests.server.service import until

CHECKOUT = Path(__file__).parents[1]
PURPOSE = "The test of the image needs Buildah and debootstrap"
ADVICE = "install them (Debian, Ubuntu: apt-get install buildah debootstrap)"
DEBIAN = "bookworm"  # its Python is 3.11
PACKAGES = "ca-certificates,python-is-python3,python3,python3-pip,python3-venv"
#: Where the settings of pip, npm and the certificates lie, if the machine has them.
SETTINGS = ("/etc/pip.conf", "/root/.config/pip/pip.conf", "/etc/npmrc", "/root/.npmrc")
CERTIFICATES = "/etc/ssl/certs/ca-certificates.crt"
MOST_BYTES = 450_000_000  #: on top of the base, as a host fetches it
MOST_UNPACKED_MB = 450
OCCUPIED = 100  #: of `OccupancyGrid.classify`
TOKEN = "a-token-of-the-tests-0123456789"


class Buildah:
    """Buildah with a storage of its own below a folder."""

    def __init__(self, folder: Path) -> None:
        self._command = (
            "buildah", "--storage-driver", "vfs", "--root", str(folder / "storage"), "--runroot", str(folder / "run"),
        )  # fmt: skip

    def command(self, *arguments: str | Path) -> list[str]:
        return [*self._command, *map(str, arguments)]

    def __call__(self, *arguments: str | Path) -> str:
        done = subprocess.run(self.command(*arguments), cwd=CHECKOUT, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
        return done.stdout.strip()


def _base(folder: Path) -> None:
    """Make a Debian with Python in a folder, in which pip may install for all, as in the images of Python."""
    command = ["debootstrap", "--variant=minbase", f"--include={PACKAGES}", DEBIAN, str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]
    for marker in folder.glob("usr/lib/python3*/EXTERNALLY-MANAGED"):
        marker.unlink()
    shutil.rmtree(folder / "var" / "cache" / "apt")
    for name in SETTINGS:
        if Path(name).is_file():
            target = folder / name.lstrip("/")
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(name, target)
    if Path(CERTIFICATES).is_file():
        shutil.copy(CERTIFICATES, folder / CERTIFICATES.lstrip("/"))


def _is_up(address: str) -> bool:
    try:
        return httpx.get(f"{address}/livez").status_code == 200
    except httpx.TransportError:
        return False


def _bytes_below(folder: str) -> int:
    counted = subprocess.run(["du", "-s", "-B1", "-x", folder], capture_output=True, text=True, check=True)
    return int(counted.stdout.split()[0])


@contextmanager
def _running(buildah: Buildah, image: str, log: Path) -> Iterator[str]:
    """Run the command of an image on a loopback port; yield the service's address."""
    configuration = json.loads(buildah("inspect", "--type", "image", image))["OCIv1"]["config"]
    command = configuration["Cmd"]
    assert command[:4] == ["gridbloom", "serve", "--host", "0.0.0.0"]
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    container = buildah("from", image)
    run = buildah.command(
        "run", "--isolation", "chroot", "--env", f"GRIDBLOOM_PORT={port}", "--env", f"GRIDBLOOM_TOKEN={TOKEN}",
        container, "--", *command[:3], "127.0.0.1", *command[4:],
    )  # fmt: skip
    with log.open("wb") as output, subprocess.Popen(run, stdout=output, stderr=subprocess.STDOUT) as process:
        try:
            yield f"http://127.0.0.1:{port}"
        finally:
            process.terminate()
            process.wait()


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.skipif(sys.platform != "linux" or os.geteuid() != 0, reason="chroot needs root on Linux")
def test_the_image_is_built_serves_and_maps_a_log(tmp_path: Path) -> None:
    for program in ("buildah", "debootstrap"):
        if shutil.which(program) is None:
            apt_install((program,), PURPOSE, ADVICE)
    buildah = Buildah(tmp_path)
    _base(tmp_path / "base")
    base = buildah("from", "scratch")
    buildah("add", base, tmp_path / "base", "/")
    for name in ("SSL_CERT_FILE", "NODE_EXTRA_CA_CERTS"):
        buildah("config", "--env", f"{name}={CERTIFICATES}", base)
    buildah("commit", base, "base")
    shutil.rmtree(tmp_path / "base")
    buildah("build", "--isolation", "chroot", "--build-arg", "BASE=localhost/base", "--tag", "gridbloom", CHECKOUT)

    for name in ("base", "gridbloom"):
        buildah("push", f"localhost/{name}", f"oci:{tmp_path / name}")
    fetched = _bytes_below(str(tmp_path / "gridbloom")) - _bytes_below(str(tmp_path / "base"))
    unpacked = [_bytes_below(buildah("mount", buildah("from", f"localhost/{n}"))) for n in ("gridbloom", "base")]
    added = (unpacked[0] - unpacked[1]) / 1e6
    print(f"on top of its base the image has {added:.0f} MB, {fetched / 1e6:.0f} MB compressed")
    assert fetched < MOST_BYTES
    assert added < MOST_UNPACKED_MB

    log, config = sample_log(40), MappingConfig()
    with (tmp_path / "run.mcap").open("wb") as file:
        write_mcap(file, log, GrowingMap(grid_for(log, config), config))
    with _running(buildah, "gridbloom", tmp_path / "service.txt") as address:
        until(lambda: _is_up(address))
        page = httpx.get(f"{address}/?token={TOKEN}", follow_redirects=True)
        assert page.status_code == 200
        assert "Gridbloom" in page.text
        assert httpx.get(f"{address}/api/logs").status_code == 401
        with Client(address, token=TOKEN) as client:
            found = client.map(client.wait(client.upload(tmp_path / "run.mcap")))
    assert (found.classify() == OCCUPIED).sum() > 0
