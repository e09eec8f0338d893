"""Connections that one worker passes to another: the socket's descriptor with what was read of the request.

Each worker has a pair of sockets for what it receives, made before the workers are forked, so that a message waits
there while a worker that has ended is replaced. (``SOCK_SEQPACKET``: a message is whole, whoever of several sends it.)
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from server.workers.places import worker_of
from server.workers.shared_class import SharedClass

MAX_HEAD = 1 << 16  #: bytes of a request up to the end of its headers; a longer one is refused where it arrives
READ_BYTES = 1 << 18  #: that asyncio reads at once: the beginning of a body may be read with the headers
BUFFER_BYTES = 1 << 20  #: of messages that wait for one worker
AT_ONCE = 32  #: connections taken in one pass of the event loop
FIGURES = b"\0figures"  #: in the place of a head: what asks for a worker's figures
FIGURES_S = 2.0  #: seconds that a worker has to answer; one that is being replaced cannot


@dataclass(frozen=True, slots=True)
class Channel:
    """The two ends of the way to one worker."""

    receiving: socket.socket
    sending: socket.socket

    @classmethod
    def make(cls) -> Channel:
        """Make both ends. Raises :class:`OSError`."""
        receiving, sending = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        sending.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
        for end in (receiving, sending):
            end.setblocking(False)
        return cls(receiving, sending)


class Handover:
    """What worker ``own`` passes to the others and gets from them, by ``channels``, one for each. Event loop only.

    ``prepared`` is the class that is open from the start, None for none.
    """

    def __init__(self, own: int, channels: Sequence[Channel], prepared: SharedClass | None = None) -> None:
        self.own = own
        self._prepared = prepared
        self._channels = channels
        self._telling: set[asyncio.Future[None]] = set()

    @property
    def workers(self) -> int:
        """Number of workers."""
        return len(self._channels)

    def begin(self, take: Callable[[socket.socket, bytes], None], figures: Callable[[], bytes]) -> None:
        """Call ``take`` with each connection that comes from now on, and what was read of it.

        ``figures`` returns what the other workers are told that ask for this one's figures.
        """
        self._take, self._figures = take, figures
        asyncio.get_running_loop().add_reader(self._channels[self.own].receiving, self._receive)

    def end(self) -> None:
        """Take no more; what comes waits for the worker that replaces this one."""
        asyncio.get_running_loop().remove_reader(self._channels[self.own].receiving)

    def other(self, head: bytes, address: str) -> int | None:
        """Return the other worker that has a request, None for one that may be answered here."""
        prepared = self._prepared
        worker = worker_of(head, address, self.workers, {} if prepared is None else {prepared.code: prepared.worker})
        return None if worker == self.own else worker

    def pass_on(self, worker: int, head: bytes, descriptor: int) -> bool:
        """Pass on a connection, of which ``head`` was read; return False where the worker's buffer is full.

        Raises :class:`OSError`.
        """
        try:
            socket.send_fds(self._channels[worker].sending, [head], [descriptor])
        except BlockingIOError:
            return False
        return True

    async def figures_of_others(self) -> list[bytes]:
        """Return the figures of the other workers, without those that do not answer now."""
        others = [worker for worker in range(self.workers) if worker != self.own]
        answers = await asyncio.gather(*map(self._figures_of, others), return_exceptions=True)
        return [answer for answer in answers if isinstance(answer, bytes)]

    async def _figures_of(self, worker: int) -> bytes:
        """Return the figures of another worker. Raises :class:`OSError`, also where there is no answer in time."""
        asking, answering = socket.socketpair()
        with answering:
            if not self.pass_on(worker, FIGURES, answering.fileno()):
                asking.close()
                raise BlockingIOError
        reader, writer = await asyncio.open_connection(sock=asking)
        try:
            async with asyncio.timeout(FIGURES_S):
                return await reader.read()
        finally:
            writer.close()

    async def _tell_figures(self, asking: socket.socket) -> None:
        with contextlib.suppress(OSError):  # it was too late
            _, writer = await asyncio.open_connection(sock=asking)
            writer.write(self._figures())
            writer.close()
            await writer.wait_closed()

    def _receive(self) -> None:
        receiving = self._channels[self.own].receiving
        for _ in range(AT_ONCE):
            try:
                head, descriptors, _, _ = socket.recv_fds(receiving, MAX_HEAD + READ_BYTES, 1)
            except BlockingIOError:
                return
            for descriptor in descriptors:  # none where descriptors have run out
                other = socket.socket(fileno=descriptor)
                if head == FIGURES:
                    self._telling.add(telling := asyncio.ensure_future(self._tell_figures(other)))
                    telling.add_done_callback(self._telling.discard)
                else:
                    self._take(other, head)
