"""Connections that one worker hands over to another: the socket's descriptor with the read part of the request.

Each worker has a pair of sockets for what it receives, created before the workers are forked, so that a message waits
there while an ended worker is replaced. (``SOCK_SEQPACKET``: messages stay whole even with several senders.)
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
READ_BYTES = 1 << 18  #: bytes that asyncio reads at once; the start of a body may be read with the headers
BUFFER_BYTES = 1 << 20  #: of waiting messages for one worker
AT_ONCE = 32  #: connections accepted in one pass of the event loop
FIGURES = b"\0figures"  #: instead of a head: requests a worker's figures
FIGURES_S = 2.0  #: seconds in which a worker must answer; one that is being replaced cannot


@dataclass(frozen=True, slots=True)
class Channel:
    """The two ends of a channel to one worker."""

    receiving: socket.socket
    sending: socket.socket

    @classmethod
    def make(cls) -> Channel:
        """Create both ends. Raises :class:`OSError`."""
        receiving, sending = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        sending.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
        for end in (receiving, sending):
            end.setblocking(False)
        return cls(receiving, sending)


class Handover:
    """The exchange of worker ``own`` with the others by ``channels``, one for each. Event loop only.

    ``prepared`` is the class that is open from the start, None without one.
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
        """From now on, call ``take`` with each received connection, and the data that was read from it.

        ``figures`` returns this worker's figures for other workers that request them.
        """
        self._take, self._figures = take, figures
        asyncio.get_running_loop().add_reader(self._channels[self.own].receiving, self._receive)

    def end(self) -> None:
        """Stop receiving; further connections wait for the worker that replaces this one."""
        asyncio.get_running_loop().remove_reader(self._channels[self.own].receiving)

    def other(self, head: bytes, address: str) -> int | None:
        """Return the other worker to which a request belongs, None if it may be answered here."""
        prepared = self._prepared
        worker = worker_of(head, address, self.workers, {} if prepared is None else {prepared.code: prepared.worker})
        return None if worker == self.own else worker

    def pass_on(self, worker: int, head: bytes, descriptor: int) -> bool:
        """Hand over a connection, of which ``head`` was read; return False if the worker's buffer is full.

        Raises :class:`OSError`.
        """
        try:
            socket.send_fds(self._channels[worker].sending, [head], [descriptor])
        except BlockingIOError:
            return False
        return True

    async def figures_of_others(self) -> list[bytes]:
        """Return the figures of the other workers, without those that currently do not answer."""
        others = [worker for worker in range(self.workers) if worker != self.own]
        answers = await asyncio.gather(*map(self._figures_of, others), return_exceptions=True)
        return [answer for answer in answers if isinstance(answer, bytes)]

    async def _figures_of(self, worker: int) -> bytes:
        """Return the figures of another worker. Raises :class:`OSError`, also after a timeout."""
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
            for descriptor in descriptors:  # none if there are no free descriptors
                other = socket.socket(fileno=descriptor)
                if head == FIGURES:
                    self._telling.add(telling := asyncio.ensure_future(self._tell_figures(other)))
                    telling.add_done_callback(self._telling.discard)
                else:
                    self._take(other, head)
