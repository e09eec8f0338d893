"""Unpacking of a folder of depth images from a zip or tar archive into an empty folder.

Only files used by the readers of depth folders are extracted, with names of plain letters, so that the archive cannot
control where files are written.
"""

from __future__ import annotations

import errno
import lzma
import re
import shutil
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import IO

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.clouds.depth_folder import DEPTH_END, INTRINSICS, POSE_END
from mapper.io.logs.archives.archive import BLOCK, Member, is_tar, members
from mapper.io.logs.archives.unpacking import Progress, opened
from mapper.io.logs.foreign import not_a_log, zipped_document

ZIP_MAGIC = b"PK\x03\x04"
EMPTY_ZIP = b"PK\x05\x06"
TUM_LISTS = ("depth.txt", "groundtruth.txt")
_TUM_IMAGE = re.compile(r"[\w.-]{1,100}\.png", re.ASCII)
_PLAIN = re.compile(r"[\w][\w.-]{0,100}", re.ASCII)
_PIECE = 1 << 20
_DAMAGE = (
    zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, NotImplementedError, ValueError, RuntimeError, OSError,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class _File:
    folder: str
    name: str
    entry: zipfile.ZipInfo | Member


def is_zip(head: bytes) -> bool:
    """Return whether a file that starts with ``head`` is a zip archive."""
    return head.startswith((ZIP_MAGIC, EMPTY_ZIP))


def is_depth_archive(path: Path, limits: Limits) -> bool:
    """Return whether a file is a tar archive with depth images. Raises :class:`ReadError` if it cannot be read."""
    with opened(path) as file:
        if not is_tar(file.read(BLOCK)):
            return False
    return _depth_root([_of_member(member) for member in members(path, limits)[0]]) is not None


def unpack_depth_archive(path: Path, into: Path, limits: Limits, progress: Progress | None = None) -> list[str]:
    """Write the files of a depth folder in the archive ``path`` into the empty folder ``into``; return notes on it.

    Raises :class:`ReadError` for a damaged archive and for one without depth images, and :class:`LimitError` for more
    files or bytes than ``limits`` allow.
    """
    with opened(path) as file:
        head = file.read(BLOCK)
    if zipped_document(head) is not None:
        raise not_a_log(head)
    if is_tar(head):
        inside, notes = members(path, limits)
        _write([_of_member(file) for file in inside], None, into, limits, path.stat().st_size, progress)
        return notes
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            if len(entries) > limits.max_depth_frames:
                raise LimitError("depth.too_many", f"The archive has more than {limits.max_depth_frames} files.")
            files = [_of_entry(entry) for entry in entries if not entry.is_dir()]
            _write(files, archive, into, limits, path.stat().st_size, progress)
    except _DAMAGE as error:
        # Disk errors; but bz2 raises one without a number for damaged data, and a wrong offset is an invalid argument.
        if isinstance(error, OSError) and error.errno not in (None, errno.EINVAL):
            raise
        raise ReadError("log.archive", "The zip archive is damaged, ends early, or is encrypted.") from error
    return []


def _of_entry(entry: zipfile.ZipInfo) -> _File:
    place = PurePosixPath(entry.filename.replace("\\", "/"))
    return _File(str(place.parent), place.name, entry)


def _of_member(member: Member) -> _File:
    return _File(member.folder, member.name, member)


def _depth_root(files: list[_File]) -> str | None:
    """Return the folder in the archive that is a depth folder, None if there is none."""
    roots = [file.folder for file in files if file.name.endswith(DEPTH_END) or file.name == TUM_LISTS[0]]
    return min(roots, key=lambda folder: (len(folder), folder)) if roots else None


def _write(
    files: list[_File], archive: zipfile.ZipFile | None, into: Path, limits: Limits, size: int,
    progress: Progress | None,
) -> None:  # fmt: skip
    root = _depth_root(files)
    if root is None:
        raise ReadError(
            "log.archive",
            f"The archive holds no folder of depth images (*{DEPTH_END} of 7-Scenes, or depth.txt of TUM). Other "
            "archives are not read: unpack them and drop the folder.",
        )
    (into / "depth").mkdir()
    members = [(file, place) for file in files if (place := _place(file, root)) is not None]
    room = limits.unpacked_bytes(size)
    for k, (wanted_file, place) in enumerate(members):
        with _opened(wanted_file, archive) as source, (into / place).open("wb") as out:
            while piece := source.read(_PIECE):
                room -= len(piece)
                if room < 0:
                    raise LimitError(
                        "depth.too_many_bytes",
                        f"The archive’s files have more than {limits.unpacked_bytes(size):,} bytes together, at "
                        f"{wanted_file.name:.80}.",
                    )
                out.write(piece)
        if progress is not None:
            progress((k + 1) / len(members))
    if not any((into / "depth").iterdir()):
        shutil.rmtree(into / "depth")


def _opened(file: _File, archive: zipfile.ZipFile | None) -> IO[bytes]:
    if isinstance(file.entry, Member):
        return file.entry.open()
    assert archive is not None  # noqa: S101 - for the type checker
    return archive.open(file.entry)


def _place(file: _File, root: str) -> str | None:
    """Return the target of a file in the folder, None if it is not extracted."""
    if file.folder == root:
        is_used = file.name.endswith((DEPTH_END, POSE_END)) or file.name in (*TUM_LISTS, *INTRINSICS)
        return file.name if is_used and _PLAIN.fullmatch(file.name) else None
    is_tum = PurePosixPath(file.folder) == PurePosixPath(root) / "depth" and _TUM_IMAGE.fullmatch(file.name)
    return f"depth/{file.name}" if is_tum and not file.name.startswith(".") else None
