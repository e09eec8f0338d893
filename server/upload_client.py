"""The requests of :class:`server.client.Client`: an upload that resumes after a broken connection, and its errors.

The client is a visitor of the service, like a browser. Its visitor id is stored in a file, so that a file that is sent
twice is stored once, and an interrupted upload is resumed when the command is run again.
"""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import tarfile
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import httpx

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.clouds.depth_folder import is_depth_folder
from mapper.io.logs import log_files
from mapper.io.maps.description import image_path, parse_description

PIECE = 1 << 18
TRIES = 6  #: consecutive attempts in which the service received no new data
#: A timeout of the service, other received bytes than assumed, too many requests, or an unavailable service.
FOR_NOW = (408, 409, 429, 503)
MOST_WAIT_S = 120.0  #: longest wait of a Retry-After that is followed

Progress = Callable[[float], None]


class ClientError(MapperError):
    """The service cannot be reached, or refuses a request; ``code`` and ``message`` are then the service's."""


@contextmanager
def as_one_file(path: Path) -> Iterator[Path]:
    """Yield a file with the log, the map or the depth images at ``path``.

    The same files yield the same archive, with the same digest. Raises :class:`ReadError` for other folders, and for a
    map's yaml whose image is not in the same folder.
    """
    files = _files_of(path)
    if len(files) == 1:
        yield files[0][1]
        return
    with tempfile.NamedTemporaryFile(suffix=".tar") as packed:
        with tarfile.open(fileobj=packed, mode="w", format=tarfile.USTAR_FORMAT) as archive:
            for name, log in files:
                info = tarfile.TarInfo(name[-100:])  # the last characters contain the number of the part
                with log.open("rb") as file:
                    info.size = os.fstat(file.fileno()).st_size
                    archive.addfile(info, file)
        packed.flush()
        yield Path(packed.name)


def _files_of(path: Path) -> list[tuple[str, Path]]:
    """Return the files that belong together at ``path``, and their names in an archive."""
    if path.is_dir() and is_depth_folder(path):
        inside = sorted(file for file in path.rglob("*") if file.is_file())
        return [(file.relative_to(path).as_posix(), file) for file in inside]
    if path.suffix.lower() in (".yaml", ".yml") and path.is_file():
        with path.open("rb") as file:
            text = file.read(DEFAULT_LIMITS.max_yaml_bytes + 1)
        image, _ = image_path(path, parse_description(text, DEFAULT_LIMITS).image)
        return [(path.name, path), (image.name, image)]
    return [(log_file.name, log_file) for log_file in log_files(path)]


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
) -> Mapping[str, Any]:
    """Send the file, with at most :data:`TRIES` attempts without progress; return the record of the log.

    Between two attempts it waits at least as long as a refusal states in Retry-After.
    """
    key = digest[:40]
    before, tries = -1, 0
    while True:
        wait_s = 0.0
        try:
            known = _unless_refused(client.get(f"/api/logs/uploads/{key}"))
            offset = int(known.json()["offset"])
            tries = 0 if offset > before else tries
            before = max(before, offset)
            answer = client.put(
                "/api/logs",
                params={"name": name, "upload": key, "sha256": digest},
                content=_pieces(file, offset, size, progress),
                headers={"Content-Range": f"bytes {offset}-{size - 1}/{size}", "Content-Length": str(size - offset)},
            )
            if _unless_refused(answer).status_code == 202:
                return dict(answer.json())
            failure: Exception = ClientError(*_refusal(answer))
        except httpx.TransportError as error:
            failure = error
        except _RefusedForNowError as refused:
            failure, wait_s = ClientError(*_refusal(refused.answer)), _retry_after_s(refused.answer)
        tries += 1
        if tries >= TRIES:
            raise failure
        time.sleep(max(wait_s, pause_s * 2 ** (tries - 1)))


class _RefusedForNowError(Exception):
    """The service refused a request after which the upload can be resumed."""

    def __init__(self, answer: httpx.Response) -> None:
        super().__init__(answer.status_code)
        self.answer = answer


def _unless_refused(answer: httpx.Response) -> httpx.Response:
    """Return an answer; raise :class:`_RefusedForNowError`, or :class:`ClientError` for a permanent refusal."""
    if answer.status_code in FOR_NOW:
        raise _RefusedForNowError(answer)
    return accepted(answer)


def _retry_after_s(answer: httpx.Response) -> float:
    """Return the wait in seconds that a refusal states, at most :data:`MOST_WAIT_S`; 0 if it states none."""
    stated = answer.headers.get("Retry-After", "")
    return min(float(stated), MOST_WAIT_S) if stated.isdecimal() else 0.0


def _pieces(file: Path, offset: int, size: int, progress: Progress | None) -> Iterator[bytes]:
    with file.open("rb") as stream:
        stream.seek(offset)
        while piece := stream.read(PIECE):
            yield piece
            offset += len(piece)
            if progress is not None:
                progress(offset / size)


def request(client: httpx.Client, pause_s: float, method: str, path: str, **options: Any) -> httpx.Response:  # noqa: ANN401 - passed on
    """Send a request; if the connection is lost, repeat it at most :data:`TRIES` times."""
    for attempt in range(TRIES - 1):
        try:
            return client.request(method, path, **options)
        except httpx.TransportError:
            time.sleep(pause_s * 2**attempt)
    return client.request(method, path, **options)


def accepted(answer: httpx.Response) -> httpx.Response:
    """Return ``answer``, or raise :class:`ClientError` with the service's sentence for a refusal."""
    if answer.is_success:
        return answer
    raise ClientError(*_refusal(answer))


def _refusal(answer: httpx.Response) -> tuple[str, str]:
    try:
        problem = answer.json()
        return str(problem["code"]), str(problem["message"])
    except (ValueError, KeyError, TypeError):
        return "client.refused", f"The service answered {answer.status_code}."


def visitor_id(visitors: Path | None, base: str) -> str:
    """Return the visitor id for the service at ``base`` from the file ``visitors``; store a new id there.

    Without a file, or if that cannot be written, the id is new.
    """
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
    with suppress(OSError):
        visitors.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(visitors) as file:
            file.write(json.dumps(known, indent=1).encode())
        visitors.chmod(0o600)
    return str(known[base])
