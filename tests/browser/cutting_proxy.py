"""A forwarder on loopback that can cut all connections and refuse new ones for a time."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress


class CuttingProxy:
    """Forwards TCP to ``target_port``. :meth:`cut` drops all connections and refuses new ones until :meth:`mend`."""

    def __init__(self, target_port: int) -> None:
        self._target_port = target_port
        self._is_cut = threading.Event()
        self._sockets: set[socket.socket] = set()
        self._lock = threading.Lock()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def cut(self) -> None:
        """Drop everything, and whoever comes next."""
        self._is_cut.set()
        with self._lock:
            for s in self._sockets:
                _hang_up(s)

    def mend(self) -> None:
        """Forward again."""
        self._is_cut.clear()

    def close(self) -> None:
        """End for good."""
        self.cut()
        _hang_up(self._listener)
        self._listener.close()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            try:
                server = socket.create_connection(("127.0.0.1", self._target_port))
            except OSError:  # the service has ended
                client.close()
                continue
            with self._lock:  # it is refused here, or cut() finds it
                is_cut = self._is_cut.is_set()
                if not is_cut:
                    self._sockets |= {client, server}
            if is_cut:
                client.close()
                server.close()
                continue
            ends = threading.Barrier(2, action=lambda pair=(client, server): self._forget(*pair))  # type: ignore[misc]
            for source, sink in ((client, server), (server, client)):
                threading.Thread(target=self._pump, args=(source, sink, ends), daemon=True).start()

    def _pump(self, source: socket.socket, sink: socket.socket, ends: threading.Barrier) -> None:
        with suppress(OSError):  # the other end hung up, or we were cut
            while data := source.recv(65536):
                sink.sendall(data)
        _hang_up(sink)
        ends.wait()

    def _forget(self, *pair: socket.socket) -> None:
        with self._lock:
            self._sockets -= set(pair)
        for s in pair:
            s.close()


def _hang_up(s: socket.socket) -> None:
    with suppress(OSError):  # it may be closed already
        s.shutdown(socket.SHUT_RDWR)


@contextmanager
def cutting_proxy(target_port: int) -> Iterator[CuttingProxy]:
    """Run a :class:`CuttingProxy` until the block ends."""
    proxy = CuttingProxy(target_port)
    try:
        yield proxy
    finally:
        proxy.close()
