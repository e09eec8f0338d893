"""How :class:`server.client.Client` sends a log to a service, and goes on after a cut.

Who uploads is a visitor of the service, as a browser is; a cookie file remembers which one, so that the same file sent
twice is one log there, and an upload that was cut goes on when it is begun again.
"""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import tarfile
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import MapperError, ReadError
from mapper.io.logs import log_files

PIECE = 1 << 18
TRIES = 6  #: in a row without a byte more

Progress = Callable[[float], None]


class ClientError(MapperError):
    """The service cannot be reached, or refuses what was asked for: then ``code`` and ``message`` are the service's."""


@contextmanager
def as_one_file(path: Path) -> Iterator[Path]:
    """Yield a file with the log at ``path``. The same files give the same archive, so that it is known again."""
    logs = log_files(path) if path.is_dir() else [path]
    if len(logs) == 1:
        yield logs[0]
        return
    with tempfile.NamedTemporaryFile(suffix=".tar") as packed:
        with tarfile.open(fileobj=packed, mode="w", format=tarfile.USTAR_FORMAT) as archive:
            for log in logs:
                info = tarfile.TarInfo(log.name[-100:])  # the end has the number that tells its place
                with log.open("rb") as file:
                    info.size = os.fstat(file.fileno()).st_size
                    archive.addfile(info, file)
        packed.flush()
        yield Path(packed.name)


def measured(file: Path) -> tuple[int, str]:
    """Return a file's size and digest."""
    try:
        with file.open("rb") as stream:
            digest = hashlib.file_digest(stream, "sha256").hexdigest()
            size = os.fstat(stream.fileno()).st_size
    except OSError as error:
        raise ReadError("log.unreadable", f"The file cannot be read: {error.strerror}.") from error
    if size == 0:
        raise ReadError("log.empty", "The file is empty.")
    return size, digest


def sent(
    client: httpx.Client, file: Path, name: str, size: int, digest: str, progress: Progress | None, pause_s: float
) -> dict[str, Any]:
    """Send the file, as often as it takes; return the record of the log."""
    key = digest[:40]
    before, tries = -1, 0
    while True:
        try:
            offset = int(accepted(client.get(f"/api/logs/uploads/{key}")).json()["offset"])
            tries = 0 if offset > before else tries
            before = max(before, offset)
            answer = client.put(
                "/api/logs",
                params={"name": name, "upload": key, "sha256": digest},
                content=_pieces(file, offset, size, progress),
                headers={"Content-Range": f"bytes {offset}-{size - 1}/{size}", "Content-Length": str(size - offset)},
            )
            if answer.status_code == 202:
                return dict(answer.json())
            if answer.status_code not in (200, 409, 503):  # those are worth another try
                accepted(answer)
            failure: Exception = ClientError(*_refusal(answer))
        except httpx.TransportError as error:
            failure = error
        tries += 1
        if tries >= TRIES:
            raise failure
        time.sleep(pause_s * 2 ** (tries - 1))


def _pieces(file: Path, offset: int, size: int, progress: Progress | None) -> Iterator[bytes]:
    with file.open("rb") as stream:
        stream.seek(offset)
        while piece := stream.read(PIECE):
            yield piece
            offset += len(piece)
            if progress is not None:
                progress(offset / size)


def request(client: httpx.Client, pause_s: float, method: str, path: str, **options: Any) -> httpx.Response:  # noqa: ANN401 - passed on
    """Send a request; where the connection is cut, again, :data:`TRIES` times at most."""
    for attempt in range(TRIES - 1):
        try:
            return client.request(method, path, **options)
        except httpx.TransportError:
            time.sleep(pause_s * 2**attempt)
    return client.request(method, path, **options)


def accepted(answer: httpx.Response) -> httpx.Response:
    """Return ``answer``, or raise :class:`ClientError` with the service's sentence where it is a refusal."""
    if answer.is_success:
        return answer
    raise ClientError(*_refusal(answer))


def _refusal(answer: httpx.Response) -> tuple[str, str]:
    try:
        told = answer.json()
        return str(told["code"]), str(told["message"])
    except (ValueError, KeyError, TypeError):
        return "client.refused", f"The service answered {answer.status_code}."


def visitor_id(visitors: Path | None, base: str) -> str:
    """Return who this is to the service at ``base``, from the file that remembers it; without one somebody new."""
    if visitors is None:
        return secrets.token_urlsafe(18)
    try:
        known = json.loads(visitors.read_text(encoding="utf-8"))
        if isinstance(known, dict) and isinstance(known.get(base), str):
            return str(known[base])
    except (OSError, ValueError):
        known = {}
    known = known if isinstance(known, dict) else {}
    known[base] = secrets.token_urlsafe(18)
    visitors.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(visitors) as file:
        file.write(json.dumps(known, indent=1).encode())
    visitors.chmod(0o600)
    return str(known[base])
