"""Map files as one upload: a tar archive of a yaml and its image, as for map_server, or a map of CMU's course.

An archive may also contain masks of the same cells, ``NAME_keepout.yaml`` of Nav2's keepout filter and
``NAME_speed.yaml`` of its speed filter, each with its image, and the edits that made the map, ``NAME.edits.json``. The
page of map editing saves such archives.
"""

from __future__ import annotations

import io
import json
import tarfile
import tempfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from mapper.core.errors import LimitError, MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.io.logs.archives.archive import BLOCK, is_tar, members
from server.library.packs.reference_map import ReferenceMap

if TYPE_CHECKING:
    from mapper.io.logs.archives.archive import Member

MOST_FILES = 8  #: in an archive
MOST_BYTES = 256 << 20  #: of all of them together
MOST_NAME_BYTES = 200  #: of a file's name
_YAML = (".yaml", ".yml")
_IMAGES = (".pgm", ".png", ".bmp", ".jpg", ".jpeg", ".tif", ".tiff", ".gif")
_MASKS = {"keepout": "_keepout", "speed": "_speed"}  #: of a map: ending of the name of its yaml
_EDITS = ".edits.json"


def archived(files: Iterable[tuple[str, bytes]]) -> bytes:
    """Return a tar archive of files, by name. The same files yield the same bytes."""
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w", format=tarfile.PAX_FORMAT) as archive:
        for name, data in files:
            member = tarfile.TarInfo(name)
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))
    return out.getvalue()


def is_map(source: Path) -> bool:
    """Return whether an upload contains map files and nothing else."""
    from mapper.io.maps.bee import is_bee_map  # noqa: PLC0415 - only the processes that read uploads read maps

    if source.is_dir():
        return False
    if is_bee_map(source):
        return True
    try:
        names = [path.name.lower() for path in _files_in(source)]
    except (OSError, MapperError):
        return False
    if not all(name.endswith((*_YAML, *_IMAGES, _EDITS)) for name in names):
        return False
    return any(name.endswith(_YAML) for name in names) and any(name.endswith(_IMAGES) for name in names)


def read_map(source: Path, title: str, scratch: Path) -> ReferenceMap:
    """Return the map in an upload; files are temporarily unpacked below ``scratch``.

    ``title`` is used for a map of CMU's course; others are named after their yaml. Raises :class:`ReadError` and
    :class:`LimitError`.
    """
    from mapper.io.maps import load_map  # noqa: PLC0415 - only the processes that read uploads read maps
    from mapper.io.maps.bee import is_bee_map  # noqa: PLC0415

    if is_bee_map(source):
        loaded = load_map(source)
        return ReferenceMap(title, loaded.grid.geometry, loaded.values, loaded.notes)
    with tempfile.TemporaryDirectory(dir=scratch) as name:
        folder = Path(name)
        names = _unpacked(source, folder)
        yamls = [name for name in names if name.lower().endswith(_YAML)]
        masks = _masks_in(yamls)
        maps = [name for name in yamls if name not in masks.values()]
        if len(maps) != 1:
            raise ReadError(
                "map.files", "Map files are one yaml and the image that it names; "
                + (f"there are {len(yamls)} yamls here." if yamls else "there is no yaml here."),
            )  # fmt: skip
        loaded = load_map(folder / maps[0])
        geometry = loaded.grid.geometry
        values = {}
        for kind, mask_yaml in masks.items():
            mask = load_map(folder / mask_yaml)
            if mask.grid.geometry != geometry:
                raise ReadError("map.mask", f"The {kind} mask {mask_yaml!r} has other cells than the map {maps[0]!r}.")
            values[kind] = mask.values.clip(0)
        made_by = [_origin_of(folder / name) for name in names if name.endswith(_EDITS)]
    return ReferenceMap(maps[0], geometry, loaded.values, (*loaded.notes, *filter(None, made_by)), **values)


def _masks_in(yamls: list[str]) -> dict[str, str]:
    """Return the first yaml of each kind of mask by name; a single yaml is a map whatever its name."""
    masks: dict[str, str] = {}
    for name in yamls if len(yamls) > 1 else ():
        for kind, ending in _MASKS.items():
            if Path(name).stem.endswith(ending):
                masks.setdefault(kind, name)
    return masks


def _origin_of(path: Path) -> str | None:
    """Return a sentence on the edits that made a map, None for a file without edits."""
    try:
        origin = json.loads(path.read_bytes())
        n, name = len(origin["edits"]), str(origin["source"]["map"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return f"Made by {n} edit{'' if n == 1 else 's'} of {name[:100]!r}." if n else None


def _files_in(source: Path) -> list[Member]:
    """Return the files in a tar archive. Raises :class:`OSError`, :class:`ReadError` and :class:`LimitError`."""
    with source.open("rb") as file:
        if not is_tar(file.read(BLOCK)):
            raise ReadError(
                "map.files", "These are not map files: choose a yaml together with its image, or a map of CMU’s course."
            )
    # Long names have their own records.
    files, _ = members(source, replace(DEFAULT_LIMITS, max_archive_files=4 * MOST_FILES))
    if len(files) > MOST_FILES:
        raise LimitError("map.files", f"Map files are a yaml and an image, at most {MOST_FILES} files.")
    return files


def _unpacked(source: Path, folder: Path) -> list[str]:
    """Extract the files of a tar archive into ``folder`` by their base names, and return these."""
    files = _files_in(source)
    if sum(file.size for file in files) > MOST_BYTES:
        raise LimitError("map.too_large", f"Map files have at most {MOST_BYTES >> 20} MiB here.")
    for file in files:
        if len(file.name.encode()) > MOST_NAME_BYTES:
            raise ReadError("map.files", f"The file name {file.name!r:.60} is too long.")
        with file.open() as content:
            (folder / file.name).write_bytes(content.read())
    return [file.name for file in files]
