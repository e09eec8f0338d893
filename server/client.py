"""A client of the service for programs: upload a log, wait until it was read, get its map, its findings and a link.

It sends the same requests as the pages, and is a visitor of the service like a browser.
"""

from __future__ import annotations

import json
import struct
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Self, TypeVar
from urllib.parse import parse_qs, urlsplit

import httpx
import msgspec
from websockets.exceptions import InvalidStatus, WebSocketException
from websockets.sync.client import connect
from websockets.sync.connection import Connection
from websockets.typing import Subprotocol

from server.network_address import is_loopback_name
from server.stream.protocol import SUBPROTOCOL
from server.upload_client import ClientError, Progress, accepted, as_one_file, measured, request, sent, visitor_id

if TYPE_CHECKING:
    from mapper.diagnosis import Finding
    from mapper.grid import OccupancyGrid

__all__ = ["Client", "ClientError", "Log", "Session"]

READ_EVERY_S = 0.2
TIMEOUT_S = 30.0  #: of a request
WORK_TIMEOUT_S = 600.0  #: of a request that requires computation
SHARED = "/shared/"  #: beginning of the path of a link
_SEQ_AT = 8  #: bytes into a binary frame, docs/wire.md


NoteFile = Literal["geojson", "csv"]
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Log:
    """A log of the service.

    ``state`` is ``queued``, ``reading``, ``ready`` or ``failed``; the figures are None until it is ``ready``.
    ``trajectories`` are names, the first being the default. ``record`` is the whole answer of the service.
    """

    id: str
    name: str
    state: str
    progress: float  #: of reading, 0 to 1
    scans: int | None
    beams: int | None
    duration_s: float | None
    format: str | None
    trajectories: tuple[str, ...]
    notes: tuple[str, ...]
    record: Mapping[str, Any] = field(repr=False)


@dataclass(frozen=True, slots=True)
class Session:
    """A session of the service: its map contains ``index`` of ``count`` scans."""

    id: str
    kind: str
    title: str
    playing: bool
    index: int
    count: int
    stream: str = field(repr=False)  #: path of its WebSocket


class _Sessions(msgspec.Struct):
    """The answer of ``/api/sessions``."""

    sessions: list[Session]


class _Link(msgspec.Struct):
    """The answer to the creation of a link: its path."""

    address: str


class Client:
    """A connection to the service at ``url``.

    ``url`` may contain the service's token, like the address that the service prints; ``token`` replaces it.
    ``visitors`` is a file that stores the visitor id for each service, so that a log that is sent twice is stored once
    and an interrupted upload is resumed in another process. Without it every client is a new visitor, who sees none of
    the logs and sessions of another. After a broken connection a request is repeated ``pause_s`` seconds later, and
    after twice the last pause at each further attempt. A proxy from the environment (``HTTPS_PROXY``) is used, except
    for a service on this machine's loopback address.

    All methods raise :class:`ClientError`: with the service's sentence if it refuses, or if it cannot be reached.
    """

    def __init__(
        self, url: str, token: str | None = None, visitors: Path | None = None, *, pause_s: float = 1.0
    ) -> None:
        parts = urlsplit(url if "//" in url else f"http://{url}")
        self.base = f"{parts.scheme}://{parts.netloc}"
        self._pause_s = pause_s
        token = token or parse_qs(parts.query).get("token", [""])[0]
        # A proxy from the environment is for other machines, because loopback would be the proxy's own.
        self._is_local = is_loopback_name(parts.hostname or "")
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        cookies = {"gridbloom_visitor": visitor_id(visitors, self.base)}
        with self._reaching():
            self._http = httpx.Client(
                base_url=self.base,
                headers=headers,
                cookies=cookies,
                timeout=TIMEOUT_S,
                trust_env=not self._is_local,
            )
        self._headers = headers | {"Cookie": "; ".join(f"{name}={value}" for name, value in cookies.items())}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection. Logs and sessions are kept by the service."""
        self._http.close()

    # -- logs ------------------------------------------------------------------------------------------------------

    def upload(self, path: Path, progress: Progress | None = None) -> Log:
        """Send the log at ``path``; return it, not read yet. ``progress`` is called with the share sent.

        If ``path`` is a folder, the log in it is sent; a log of several files is sent as a tar archive. After a broken
        connection the upload resumes at the last byte that the service has: after ``pause_s`` seconds, and after twice
        the last pause at each further attempt. Raises :class:`ReadError` for a file that cannot be read.
        """
        with as_one_file(path) as file:
            size, digest = measured(file)
            with self._reaching():
                return _log(sent(self._http, file, path.resolve().name, size, digest, progress, self._pause_s))

    def wait(self, log: Log, progress: Progress | None = None) -> Log:
        """Return ``log`` once the service has read it. ``progress`` is called with the share read.

        Raises :class:`ClientError` with the reason if it cannot be read.
        """
        while log.state in ("queued", "reading"):
            if progress is not None:
                progress(log.progress)
            time.sleep(READ_EVERY_S)
            log = self.log(log.id)
        if log.state == "failed":
            error = log.record["error"]
            raise ClientError(error["code"], error["message"])
        return log

    def logs(self) -> list[Log]:
        """Return the logs that this visitor may open."""
        return [_log(record) for record in self._answer("GET", "/api/logs").json()["logs"]]

    def log(self, log_id: str) -> Log:
        """Return the current state of a log."""
        return _log(self._answer("GET", f"/api/logs/{log_id}").json())

    def delete(self, log: Log) -> None:
        """Delete a log that this visitor uploaded, and its links."""
        self._send("DELETE", f"/api/logs/{log.id}")

    # -- sessions --------------------------------------------------------------------------------------------------

    def open(
        self,
        log: Log,
        *,
        topic: str | None = None,
        trajectory: str | None = None,
        cut: Mapping[str, float] | None = None,
        playing: bool = False,
    ) -> Session:
        """Begin a session on a log with an empty map; if ``playing``, scans are added from the start.

        Clouds are shown as a 3D map, map files in an editor, and recorded costmaps as such. ``topic`` names the sensor,
        or several separated by " + "; ``cut`` has the options for cutting scans out of clouds and depth images, values
        of :data:`mapper.sensors.planar.options.PARAMETERS`.
        """
        # A log of clouds has no planar scans.
        of_kind = {"kind": "volume"} if log.record["clouds"] else {"kind": "log", "trajectory": trajectory}
        cut_out = {} if cut is None else {"cut": dict(cut)}
        request = {"log": log.id, "topic": topic, "playing": playing, **of_kind, **cut_out}
        return self._asked(Session, "POST", "/api/sessions", json=request)

    def sessions(self) -> list[Session]:
        """Return the sessions that this visitor began."""
        return self._asked(_Sessions, "GET", "/api/sessions").sessions

    def session(self, session_id: str) -> Session:
        """Return the current state of a session."""
        return self._asked(Session, "GET", f"/api/sessions/{session_id}")

    def seek(self, session: Session, index: int | None = None) -> Session:
        """Pause a session of a log, seek its map to ``index`` scans (None: all), and return it."""
        target = session.count if index is None else index
        with self._reaching(), self._stream(session) as socket:
            for command in (
                {"type": "subscribe", "layers": []},
                {"type": "pause"},
                {"type": "seek", "index": target},
            ):
                socket.send(json.dumps(command))
            for data in socket:
                if isinstance(data, bytes):
                    (seq,) = struct.unpack_from("<I", data, _SEQ_AT)
                    socket.send(json.dumps({"type": "ack", "seq": seq}))
                    continue
                message = json.loads(data)
                if message["type"] == "error":
                    raise ClientError(message["code"], message["message"])
                if message["type"] == "frame" and message["index"] == target:
                    return self.session(session.id)
        raise ClientError("client.stream", "The service closed the stream of the session before the map was complete.")

    def end(self, session: Session) -> None:
        """End a session that this visitor began."""
        self._send("DELETE", f"/api/sessions/{session.id}")

    def address(self, session: Session) -> str:
        """Return the address of the page of a log's session, for users of the service."""
        kind = "" if session.kind == "log" else f"&kind={session.kind}"
        return f"{self.base}/logs.html?session={session.id}{kind}"

    @contextmanager
    def at(self, address: str) -> Iterator[Log | Session]:
        """Yield the log or session of the page at ``address``, or a temporary session of a link."""
        parts = urlsplit(address)
        query = parse_qs(parts.query)
        if "session" in query:
            yield self.session(query["session"][0])
        elif "log" in query:
            yield self.log(query["log"][0])
        elif parts.path.startswith(SHARED):
            token = parts.path.removeprefix(SHARED)
            session = self._asked(Session, "POST", f"/api/shared/{token}/sessions", timeout=WORK_TIMEOUT_S)
            try:
                yield session
            finally:
                with suppress(ClientError):  # without the token it cannot be ended, and ends after idling
                    self.end(session)
        else:
            raise ClientError("client.address", "This is the address neither of a log's page nor of a link to one.")

    def link(self, session: Session) -> str:
        """Create a read-only link to the current view of a log's session. It needs no token. Valid until revoked."""
        return self.base + self._asked(_Link, "POST", f"/api/sessions/{session.id}/links", json={}).address

    # -- maps and findings -----------------------------------------------------------------------------------------

    def map(self, of: Log | Session) -> OccupancyGrid:
        """Return the current map of a session, or the map of all scans of a log.

        It is downloaded as map.yaml and map.pgm: each cell has its state in the service's map (free, occupied or
        unknown), not its log-odds.
        """
        from mapper.core.limits import DEFAULT_LIMITS  # noqa: PLC0415 - start-up
        from mapper.io.maps import load_map  # noqa: PLC0415 - start-up
        from mapper.io.maps.description import parse_description  # noqa: PLC0415 - start-up

        with self._session_of(of, whole=True) as session, tempfile.TemporaryDirectory() as folder:
            # The same name in both requests makes them refer to one instant.
            path, at = f"/api/sessions/{session.id}", {"at": "client-" + str(time.time_ns())}
            yaml = self._answer("GET", f"{path}/map.yaml", params=at, timeout=WORK_TIMEOUT_S).content
            pgm = self._answer("GET", f"{path}/map.pgm", params=at, timeout=WORK_TIMEOUT_S).content
            (Path(folder) / "map.yaml").write_bytes(yaml)
            (Path(folder) / Path(parse_description(yaml, DEFAULT_LIMITS).image).name).write_bytes(pgm)
            return load_map(Path(folder) / "map.yaml").grid

    def picture(self, of: Log | Session) -> bytes:
        """Return the same map as :meth:`map`, as a PNG image in which a cell's grey value is its probability."""
        with self._session_of(of, whole=True) as session:
            return self._answer("GET", f"/api/sessions/{session.id}/map.png", timeout=WORK_TIMEOUT_S).content

    def doctor(self, of: Log | Session) -> list[Finding]:
        """Return the doctor's findings in a log, with the session's trajectory or by default the log's first."""
        from mapper.diagnosis import Finding  # noqa: PLC0415 - start-up

        with self._session_of(of, whole=False) as session:
            answer = self._answer("GET", f"/api/sessions/{session.id}/doctor", timeout=WORK_TIMEOUT_S)
        return msgspec.convert(answer.json()["findings"], list[Finding])

    def notes(self, of: Log | Session, ending: NoteFile = "geojson") -> bytes:
        """Return the notes on a log as GeoJSON or CSV; coordinates are metres in the frame of the poses."""
        with self._session_of(of, whole=False) as session:
            return self._answer("GET", f"/api/sessions/{session.id}/notes.{ending}").content

    # -- requests --------------------------------------------------------------------------------------------------

    @contextmanager
    def _session_of(self, of: Log | Session, *, whole: bool) -> Iterator[Session]:
        """Yield a session; for a log, a temporary one, if ``whole`` with the entire log in its map."""
        if isinstance(of, Session):
            yield of
            return
        session = self.open(of)
        try:
            yield self.seek(session) if whole else session
        finally:
            self.end(session)

    @contextmanager
    def _stream(self, session: Session) -> Iterator[Connection]:
        parts = urlsplit(self.base)
        uri = f"{'wss' if parts.scheme == 'https' else 'ws'}://{parts.netloc}{session.stream}"
        try:
            with connect(
                uri,
                subprotocols=[Subprotocol(SUBPROTOCOL)],
                additional_headers=self._headers,
                compression=None,
                max_size=None,
                open_timeout=TIMEOUT_S,
                proxy=None if self._is_local else True,
            ) as socket:
                yield socket
        except InvalidStatus as error:
            status = error.response.status_code
            raise ClientError("client.stream", f"The service refused the session's stream: {status}.") from error
        except WebSocketException as error:
            raise ClientError("client.stream", f"The session's stream was cut: {error}.") from error

    def _asked(self, kind: type[T], method: str, path: str, **options: Any) -> T:  # noqa: ANN401 - httpx's own
        return msgspec.json.decode(self._answer(method, path, **options).content, type=kind)

    def _send(self, method: str, path: str) -> None:
        self._answer(method, path)

    def _answer(self, method: str, path: str, **options: Any) -> httpx.Response:  # noqa: ANN401 - httpx's own
        with self._reaching():
            return accepted(request(self._http, self._pause_s, method, path, **options))

    @contextmanager
    def _reaching(self) -> Iterator[None]:
        """Report that the service cannot be reached."""
        try:
            yield
        except (httpx.HTTPError, httpx.InvalidURL, OSError, ValueError) as error:
            raise ClientError(
                "client.unreachable", f"The service at {self.base} cannot be reached: {error}."
            ) from error


def _log(record: Mapping[str, Any]) -> Log:
    return Log(
        record["id"],
        record["name"],
        record["state"],
        record["progress"],
        record["scans"],
        record["beams"],
        record["duration_s"],
        record["format"],
        tuple(trajectory["name"] for trajectory in record["trajectories"]),
        tuple(record["notes"]),
        record,
    )
