"""Files in a tar archive, read in place: nothing is unpacked, and no name in it is used as a path.

Source: POSIX.1-2017, pax (the ustar format, and the record ``path`` of its extended headers); the GNU tar manual (long
names, base-256 numbers). Other contents of archives, such as links, are ignored.

Python's ``tarfile`` is not used: it reads names of any length into memory, calls itself for every record of a name
(thousands of them end in RecursionError) and seeks to wherever a false size points, also backwards.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Literal

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.logs.names import printable

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer as Buffer

MAGIC, MAGIC_AT = b"ustar", 257
BLOCK = 512
MAX_NAME_BYTES = 1 << 14  #: of a name with a separate record
HEAD_BYTES = 1 << 18  #: cached per file of a compressed archive
REGULAR, WITHOUT_DATA, LONG_NAME, EXTENDED = b"0\x007", b"123456", b"L", b"x"


@dataclass(frozen=True, slots=True)
class Member:
    """A file in an archive: ``size`` bytes of the file ``archive``, starting at ``at``. Opened like a path.

    ``unpacked`` opens the decompressed archive, in which ``at`` is then an offset; None: it is not compressed. ``head``
    are then its first bytes, because reading them again would decompress the archive up to them. ``journal`` is
    SQLite's write-ahead log next to it, with the same name plus ``-wal``.
    """

    name: str
    folder: str
    archive: Path
    at: int
    size: int
    unpacked: Callable[[Path], BinaryIO] | None = field(default=None, compare=False)
    head: bytes | None = field(default=None, compare=False, repr=False)
    journal: Member | None = field(default=None, compare=False, repr=False)

    def open(self, mode: Literal["rb"] = "rb") -> BinaryIO:
        """Open its bytes as a file. Raises :class:`OSError`."""
        file = self.archive.open(mode) if self.unpacked is None else self.unpacked(self.archive)
        window: io.RawIOBase = _Window(file, self.at, self.size)
        return io.BufferedReader(window)


Source = Path | Member  #: a file that a reader can open


class _Window(io.RawIOBase):
    """A byte range of an open file, which it closes at the end."""

    def __init__(self, file: BinaryIO, at: int, size: int) -> None:
        self._file, self._begin, self._size = file, at, size
        self._at = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        self._at = max(0, offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._size}[whence])
        return self._at

    def readinto(self, buffer: Buffer) -> int:
        view = memoryview(buffer)
        self._file.seek(self._begin + self._at)
        data = self._file.read(min(len(view), max(0, self._size - self._at)))
        view[: len(data)] = data
        self._at += len(data)
        return len(data)

    def close(self) -> None:
        self._file.close()
        super().close()


class _NoHeaderError(Exception):
    """The bytes are not a header."""


def is_tar(head: bytes) -> bool:
    """Return whether a file that starts with ``head`` is a tar archive."""
    return head.startswith(MAGIC, MAGIC_AT)


def members(
    archive: Path, limits: Limits, unpacked: Callable[[Path], BinaryIO] | None = None
) -> tuple[list[Member], list[str]]:
    """Return the files in an archive in order, except hidden ones, and notes on its end.

    ``unpacked`` opens the decompressed archive; its errors are passed on. Raises :class:`ReadError` for an unreadable
    file and :class:`LimitError` for too many files.
    """
    listed: list[Member] = []
    with archive.open("rb") if unpacked is None else unpacked(archive) as file:
        end = file.seek(0, io.SEEK_END)
        at = count = 0
        name = ""
        try:
            while at + BLOCK <= end:
                file.seek(at)
                header = file.read(BLOCK)
                if not header.strip(b"\0"):
                    return _with_journals(listed), []
                kind, size, stated = _header(header)
                count += 1
                if count > limits.max_archive_files:
                    raise LimitError(
                        "log.too_many_files", f"The archive has more than {limits.max_archive_files} files."
                    )
                start = at + BLOCK
                at = start if kind in WITHOUT_DATA else start + -(-size // BLOCK) * BLOCK
                if kind in (LONG_NAME, EXTENDED):
                    name = _long_name(kind, file.read(min(size, MAX_NAME_BYTES))) or name
                    continue
                folder, _, last = (name or stated).replace("\\", "/").rpartition("/")
                name = ""
                if kind in REGULAR and last and not last.startswith("."):
                    there = max(0, min(size, end - start))
                    head = None if unpacked is None else file.read(min(there, HEAD_BYTES))
                    listed.append(Member(printable(last[:200]), folder, archive, start, there, unpacked, head))
        except _NoHeaderError:
            return _with_journals(listed), [f"The archive is damaged at byte {at}: only what precedes is read."]
        except OSError as error:
            raise ReadError("log.unreadable", f"The archive cannot be read: {error.strerror}.") from error
    return _with_journals(listed), ["The archive ends early: only what precedes is read."]


def _with_journals(members: list[Member]) -> list[Member]:
    by_place = {(member.folder, member.name): member for member in members}
    return [replace(member, journal=by_place.get((member.folder, f"{member.name}-wal"))) for member in members]


def _header(header: bytes) -> tuple[bytes, int, str]:
    """Return a header's kind, the size of the following data, and the name. Raises :class:`_NoHeaderError`."""
    if _number(header[148:156]) != sum(header) - sum(header[148:156]) + 8 * ord(" "):
        raise _NoHeaderError
    name = header[:100].split(b"\0", 1)[0]
    prefix = header[345:500].split(b"\0", 1)[0] if header[257:263] == b"ustar\0" else b""
    return header[156:157], _number(header[124:136]), b"/".join(filter(None, (prefix, name))).decode("utf-8", "replace")


def _number(field: bytes) -> int:
    if field[0] & 0x80:
        return int.from_bytes(bytes([field[0] & 0x7F]) + field[1:], "big")
    try:
        return int(field.strip(b" \0") or b"0", 8)
    except ValueError:
        raise _NoHeaderError from None


def _long_name(kind: bytes, data: bytes) -> str:
    """Return the name that a separate record states for the next file; "" if it states none."""
    if kind == LONG_NAME:
        return data.split(b"\0", 1)[0].decode("utf-8", "replace")
    _, _, path = data.partition(b" path=")  # other records may come before it
    return path.split(b"\n", 1)[0].decode("utf-8", "replace")
