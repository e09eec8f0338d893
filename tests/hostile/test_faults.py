"""Random kills, cut uploads and full disks, one after the other: every upload that was acknowledged is kept.

Each round does one of them to a service on the same folder. After each start, and at the end, the bytes of every
acknowledged upload are in the folder by their SHA-256, and the service lists it; nothing else is left behind.
"""

from __future__ import annotations

import hashlib
import os
import random
import resource
import socket
import threading
import time
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.hostile.test_crash import WHO, files, put, served, uploads
from tests.server.library.small_logs import carmen
from tests.server.service import PATIENCE_S, until

ROUNDS = int(os.environ.get("GRIDBLOOM_FAULTS", "1000"))
MOST_KEPT = 24  #: uploads; older ones are deleted

pytestmark = pytest.mark.skipif(not hasattr(resource, "prlimit"), reason="limits of another process are Linux's")


@dataclass
class Ledger:
    """Acknowledgements of the service: the SHA-256 of each upload by its id, and uploads that may be there."""

    kept: dict[str, str] = field(default_factory=dict)
    unsure: dict[str, str] = field(default_factory=dict)  #: by name, sent without an answer: there or not
    lines: dict[str, int] = field(default_factory=dict)  #: scans, by SHA-256

    def check(self, folder: Path, client: httpx.Client) -> None:
        """Compare the folder and the list of the service with what was acknowledged."""
        listed = {log["id"]: log for log in uploads(client).values()}
        for log_id, sha256 in self.kept.items():
            assert log_id in listed
            assert hashlib.sha256((folder / "library" / "blobs" / sha256).read_bytes()).hexdigest() == sha256
        for log_id in listed.keys() - self.kept.keys():  # stored, and the answer did not arrive
            self.kept[log_id] = self.unsure[listed[log_id]["name"]]
        self.unsure.clear()


class Faults:
    """One service at a time on one folder, and what is done to it."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.random, self.ledger = folder, random.Random(seed), Ledger()
        self.number = 0
        self.done: dict[str, int] = {}

    def new(self) -> tuple[str, bytes]:
        self.number += 1
        scans = self.random.randrange(5, 400)
        data = carmen(scans) + b"# upload %d\n" % self.number
        sha256 = hashlib.sha256(data).hexdigest()
        self.ledger.lines[sha256] = scans
        self.ledger.unsure[f"log {self.number}"] = sha256
        return f"log {self.number}", data

    def upload(self, client: httpx.Client) -> int:
        """Upload a new log; return the status, 0 without an answer."""
        name, data = self.new()
        try:
            answer = put(client, name, data)
        except httpx.HTTPError:
            return 0
        sha256 = self.ledger.unsure.pop(name)
        if answer.status_code == 202:
            self.ledger.kept[answer.json()["id"]] = sha256
        return answer.status_code

    def forget(self, client: httpx.Client) -> None:
        """Delete the oldest uploads."""
        for log_id in list(self.ledger.kept)[:-MOST_KEPT]:
            answer = client.delete(f"/api/logs/{log_id}")
            assert answer.status_code == 204, answer.text
            del self.ledger.kept[log_id]

    def cut(self, client: httpx.Client) -> None:
        """Close the connection in the middle of an upload."""
        name, data = self.new()
        del self.ledger.unsure[name]
        port = client.base_url.port or 0
        head = f"PUT /api/logs?name=cut HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nCookie: {WHO['Cookie']}\r\n"
        with socket.create_connection(("127.0.0.1", port)) as half:
            half.sendall(f"{head}Content-Length: {len(data)}\r\n\r\n".encode())
            half.sendall(data[: self.random.randrange(len(data))])

    def fill(self, client: httpx.Client, pid: int) -> None:
        """Upload while no file of the service may grow beyond some bytes."""
        unlimited = resource.prlimit(pid, resource.RLIMIT_FSIZE)
        resource.prlimit(pid, resource.RLIMIT_FSIZE, (self.random.choice((0, 500, 5_000, 50_000)), unlimited[1]))
        try:
            assert self.upload(client) in (202, 507)
            assert client.get("/livez").status_code == 200
        finally:
            resource.prlimit(pid, resource.RLIMIT_FSIZE, unlimited)

    def run(self, rounds: int) -> None:
        """Do one thing in each round, the service being started again after each kill."""
        left = rounds
        while left > 0:
            with served(self.folder) as (process, client):
                self.ledger.check(self.folder, client)
                self.forget(client)
                is_running = True
                while is_running and left > 0:
                    left -= 1
                    kind = self.random.choice(("cut", "fill", "upload", "kill", "kill while uploading"))
                    self.done[kind] = self.done.get(kind, 0) + 1
                    if kind == "cut":
                        self.cut(client)
                    elif kind == "fill":
                        self.fill(client, process.pid)
                    elif kind == "upload":
                        assert self.upload(client) == 202
                    else:
                        is_running = False
                        with ExitStack() as stack:
                            if kind == "kill while uploading":
                                # A small upload takes a few hundredths of a second: the kill hits any part of one.
                                killing = threading.Timer(self.random.uniform(0.0, 0.2), process.kill)
                                killing.start()
                                stack.callback(killing.join)
                                while self.upload(client) == 202:
                                    pass
                            process.kill()
                        process.wait(PATIENCE_S)
        self.end()

    def end(self) -> None:
        """At last every upload that was acknowledged is read, and no part of another one is left."""
        with served(self.folder) as (_, client):
            self.ledger.check(self.folder, client)
            for log_id, sha256 in self.ledger.kept.items():
                last = self._read(client, log_id)
                if last["state"] == "failed":
                    # The service was killed three times while it read this log, or the disk was full then.
                    assert last["error"]["code"] in ("log.interrupted", "log.reader_failed", "log.storage"), last
                    assert client.post(f"/api/logs/{log_id}/read").status_code < 300
                    last = self._read(client, log_id)
                assert (last["state"], last["scans"]) == ("ready", self.ledger.lines[sha256])
            until(lambda: files(self.folder)["incoming"] == 0)
            assert files(self.folder)["blobs"] == len(set(self.ledger.kept.values()))

    @staticmethod
    def _read(client: httpx.Client, log_id: str) -> dict[str, Any]:
        def now() -> dict[str, Any] | None:
            log = client.get(f"/api/logs/{log_id}").json()
            return log if log["state"] in ("ready", "failed") else None

        return dict(until(now))


@pytest.mark.long
def test_every_acknowledged_upload_survives_random_kills_cuts_and_full_disks(tmp_path: Path) -> None:
    seed = int(os.environ.get("GRIDBLOOM_FAULTS_SEED", "0")) or random.SystemRandom().randrange(1 << 31)
    faults = Faults(tmp_path, seed)
    began = time.monotonic()
    try:
        faults.run(ROUNDS)
    finally:
        with suppress(OSError):
            print(f"seed {seed}: {faults.done} in {time.monotonic() - began:.0f} s, {len(faults.ledger.lines)} logs")
