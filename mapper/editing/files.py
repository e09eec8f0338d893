"""Files of edited maps and of their edits."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np

from mapper.core.array_types import Int8Array
from mapper.core.atomic_file import atomic_write
from mapper.core.errors import ConfigError, LimitError, ReadError
from mapper.editing.edited_map import MAX_EDITS, EditedMap
from mapper.editing.operations import Operation, operation_dict, parse_operation
from mapper.grid.occupancy_grid import GridGeometry
from mapper.io.maps import yaml_text
from mapper.io.maps.images import pgm_header

FORMAT = "gridbloom map edits"
VERSION = 1
MAX_BYTES = 16 << 20  #: of a file of edits


class EditSource(msgspec.Struct, frozen=True):
    """The map that edits are of, as their file states it: None is not stated.

    ``width`` and ``height`` are in cells, ``resolution`` is in metres a cell, ``origin`` is x, y (m) and yaw (rad).
    """

    width: int | None = None
    height: int | None = None
    resolution: float | None = None
    origin: tuple[float, float, float] | None = None


def edits_text(edited: EditedMap, source: str = "") -> str:
    """Return the edits as JSON, one operation per line. ``source`` names the edited map."""
    geometry = edited.source
    head = {
        "format": FORMAT,
        "version": VERSION,
        "source": {
            "map": source,
            "width": geometry.cols,
            "height": geometry.rows,
            "resolution": geometry.resolution,
            "origin": list(geometry.origin),
        },
    }
    lines = ",\n  ".join(json.dumps(operation_dict(operation)) for operation in edited.operations)
    return f'{json.dumps(head)[:-1]}, "edits": [\n  {lines}\n]}}\n'


def read_edits(path: str | os.PathLike[str]) -> tuple[EditSource, list[Operation]]:
    """Return the edits in a file like :func:`parse_edits`; also raises :class:`ReadError` if it cannot be read."""
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        message = f"The file {Path(path).name!r} cannot be read: {error.strerror}."
        raise ReadError("edits.unreadable", message) from error
    return parse_edits(data)


def parse_edits(data: bytes) -> tuple[EditSource, list[Operation]]:
    """Return the source stated in a file of edits, and its operations.

    Raises :class:`ReadError` for bytes that are no such file or a source of other types, :class:`ConfigError` for an
    impossible edit, with its number, and :class:`LimitError` for more than 16 MiB or 2,000 edits.
    """
    if len(data) > MAX_BYTES:
        raise LimitError("edits.too_large", f"A file of edits may have at most {MAX_BYTES >> 20} MiB.")
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise ReadError("edits.json", f"The edits are not JSON: {error}.") from error
    if (
        not isinstance(document, dict)
        or document.get("format") != FORMAT
        or not isinstance(document.get("edits"), list)
    ):
        raise ReadError("edits.format", f"The file holds no edits: its 'format' is not {FORMAT!r}.")
    if document.get("version") != VERSION:
        raise ReadError("edits.version", f"The edits are of version {document.get('version')!r:.20}, not {VERSION}.")
    if len(document["edits"]) > MAX_EDITS:
        raise LimitError("edit.too_many", f"A map can have at most {MAX_EDITS} edits.")
    operations = []
    for k, entry in enumerate(document["edits"]):
        try:
            operations.append(parse_operation(entry))
        except ConfigError as error:
            raise ConfigError(error.code, f"Edit {k + 1}: {error.message}") from error
    try:
        source = msgspec.convert(document.get("source") or {}, EditSource)
    except msgspec.ValidationError as error:
        raise ReadError(
            "edits.source", f"The map that the edits are of, 'source', is not as it must be: {error}."
        ) from None
    return source, operations


def apply_edits(edited: EditedMap, source: EditSource, operations: Sequence[Operation]) -> None:
    """Apply the operations of a file of edits.

    Raises :class:`ConfigError` for edits of a map with another size or pose, and, with the edit's index, the errors of
    :meth:`EditedMap.apply`.
    """
    geometry = edited.source
    width = geometry.cols if source.width is None else source.width
    height = geometry.rows if source.height is None else source.height
    if (width, height) != (geometry.cols, geometry.rows):
        raise ConfigError(
            "edits.other_map",
            f"The edits are of a map of {width} × {height} cells, but this one has {geometry.size_text}.",
        )
    resolution = geometry.resolution if source.resolution is None else source.resolution
    place = [resolution, *(source.origin or geometry.origin)]
    if not np.allclose(place, [geometry.resolution, *geometry.origin], atol=1e-6):
        raise ConfigError("edits.other_map", "The edits are of a map with another resolution or origin than this one.")
    for k, operation in enumerate(operations):
        try:
            edited.apply(operation)
        except ConfigError as error:
            raise ConfigError(error.code, f"Edit {k + 1}: {error.message}") from error


def image_of(values: Int8Array) -> tuple[str, bytes]:
    """Return the mode and the PGM of values (rows, cols): trinary if there are only 0, 100 and −1, else raw."""
    is_trinary = bool(np.isin(values, (-1, 0, 100)).all())
    table = np.arange(256, dtype=np.uint8)
    table[255] = 255
    if is_trinary:
        table[[0, 100, 255]] = 254, 0, 205
    pixels = table[GridGeometry.to_image(values).view(np.uint8)]
    return ("trinary" if is_trinary else "raw"), pgm_header(values.shape) + pixels.tobytes()


def map_files(edited: EditedMap, stem: str, source: str = "", frame: str | None = None) -> Iterator[tuple[str, bytes]]:
    """Yield the names and the contents of the files of an edited map.

    These are the image and its yaml; if there are keepout zones those of their mask, ``stem_keepout``; if there are
    speed limits those of theirs, ``stem_speed``; and if there are edits ``stem.edits.json``. Masks use mode raw, in
    which map_server reads the greys 0 … 100 as values.
    """
    mode, image = image_of(edited.values)
    yield f"{stem}.pgm", image
    yield f"{stem}.yaml", yaml_text(edited.geometry, f"{stem}.pgm", mode, frame=frame).encode()  # type: ignore[arg-type]
    for name, mask in (("keepout", edited.keepout), ("speed", edited.speed)):
        if mask.any():
            pixels = GridGeometry.to_image(mask).view(np.uint8)
            yield f"{stem}_{name}.pgm", pgm_header(mask.shape) + pixels.tobytes()
            yield f"{stem}_{name}.yaml", yaml_text(edited.geometry, f"{stem}_{name}.pgm", "raw", frame=frame).encode()
    if edited.operations:
        yield f"{stem}.edits.json", edits_text(edited, source).encode()


def save_edited(
    edited: EditedMap, prefix: str | os.PathLike[str], source: str = "", frame: str | None = None
) -> list[Path]:
    """Write the files of an edited map with the given ``prefix``, each atomically; return their paths.

    Raises :class:`ConfigError` if one cannot be written.
    """
    base = Path(prefix)
    if not base.name:
        raise ConfigError("map.prefix", f"A map needs a file name, which {str(prefix)!r} lacks.")
    paths = []
    try:
        base.parent.mkdir(parents=True, exist_ok=True)
        for name, data in map_files(edited, base.name, source, frame):
            path = base.with_name(name)
            with atomic_write(path) as file:
                file.write(data)
            paths.append(path)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise ConfigError("map.unwritable", f"The map {base.name!r} cannot be written: {reason}.") from error
    return paths
