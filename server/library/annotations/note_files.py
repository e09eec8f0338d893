"""Notes on a log as files for other programs: GeoJSON (RFC 7946), which can also be read, and CSV.

Coordinates are metres in the frame of the map, not degrees. RFC 7946, 4 allows that if all users of a file agree, and
each file says so.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

import msgspec
from msgspec import Struct

from mapper.core.errors import ReadError
from server.csv_text import as_text
from server.library.annotations.areas import Corner, area_of
from server.library.annotations.notes import Note, Pin

COLUMNS = ("id", "text", "seconds", "scan", "frame", "x_m", "y_m", "area_m2", "outline", "created", "changed")


@dataclass(frozen=True, slots=True)
class MapFrame:
    """The frame of a map: its name, and the offset to add to a place on the map for its coordinates there, metres."""

    name: str
    offset: Corner = (0.0, 0.0)

    def place(self, x: float, y: float) -> Corner:
        """Return the coordinates of a place on the map."""
        return x + self.offset[0], y + self.offset[1]


def notes_as_geojson(notes: Sequence[Note], frame: MapFrame, title: str) -> str:
    """Return notes as a FeatureCollection: a place is a Point, an area a Polygon, a time alone has no geometry."""
    return json.dumps(
        {
            "type": "FeatureCollection",
            "name": title,
            "frame": frame.name,
            "unit": "m",
            "remark": f"Coordinates are metres in the frame {frame.name!r} of the poses, not longitude and latitude.",
            "features": [_feature_of(note, frame) for note in notes],
        },
        ensure_ascii=False,
    )


class _Point(Struct, tag_field="type", tag="Point"):
    coordinates: list[float]


class _Polygon(Struct, tag_field="type", tag="Polygon"):
    coordinates: list[list[list[float]]]


class _Properties(Struct):
    text: str
    seconds: float | None = None
    scan: int | None = None


class _Feature(Struct):
    properties: _Properties
    geometry: _Point | _Polygon | None = None


class _Features(Struct, tag_field="type", tag="FeatureCollection"):
    features: list[_Feature]


def notes_from_geojson(data: bytes, frame: MapFrame) -> list[tuple[str, Pin]]:
    """Return the text and the place of each note in a file that :func:`notes_as_geojson` wrote for ``frame``.

    Only the outer ring of a polygon is used. Raises :class:`ReadError` for another file, and :class:`MapperError` like
    :class:`Pin`.
    """
    try:
        features = msgspec.json.decode(data, type=_Features).features
        return [(feature.properties.text, _pin(feature, frame)) for feature in features]
    except (msgspec.DecodeError, ValueError, IndexError) as error:
        raise ReadError("notes.file", f"These are not notes as GeoJSON: {error}.") from None


def _pin(feature: _Feature, frame: MapFrame) -> Pin:
    about, geometry = feature.properties, feature.geometry

    def place(coordinates: list[float]) -> Corner:
        x, y = coordinates[:2]
        return x - frame.offset[0], y - frame.offset[1]

    if isinstance(geometry, _Polygon):
        ring = tuple(place(corner) for corner in geometry.coordinates[0])
        return Pin(about.seconds, about.scan, outline=ring[:-1] if ring[0] == ring[-1] else ring)
    return Pin(about.seconds, about.scan, *(() if geometry is None else place(geometry.coordinates)))


def notes_as_csv(notes: Sequence[Note], frame: MapFrame) -> str:
    """Return notes as a table; an area is a polygon in WKT."""
    file = io.StringIO()
    table = csv.writer(file, lineterminator="\r\n")
    table.writerow(COLUMNS)
    for note in notes:
        pin = note.pin
        ring = "" if pin.outline is None else ", ".join(f"{x!r} {y!r}" for x, y in _ring(pin.outline, frame))
        place = ("", "", "") if pin.x is None or pin.y is None else (as_text(frame.name), *frame.place(pin.x, pin.y))
        table.writerow(
            [
                note.id,
                as_text(note.text),
                pin.at_s,
                pin.scan,
                *place,
                "" if pin.outline is None else round(abs(area_of(pin.outline)), 4),
                ring and f"POLYGON (({ring}))",
                _utc(note.created_s),
                _utc(note.changed_s),
            ]
        )
    return file.getvalue()


def _feature_of(note: Note, frame: MapFrame) -> dict[str, object]:
    pin = note.pin
    geometry: dict[str, object] | None = None
    more: dict[str, float] = {}
    if pin.outline is not None:
        geometry = {"type": "Polygon", "coordinates": [_ring(pin.outline, frame)]}
        more = {"area_m2": round(abs(area_of(pin.outline)), 4)}
    elif pin.x is not None and pin.y is not None:
        geometry = {"type": "Point", "coordinates": frame.place(pin.x, pin.y)}
    about = {"text": note.text, "seconds": pin.at_s, "scan": pin.scan}
    times = {"created": _utc(note.created_s), "changed": _utc(note.changed_s)}
    return {"type": "Feature", "id": note.id, "geometry": geometry, "properties": about | more | times}


def _ring(outline: Sequence[Corner], frame: MapFrame) -> list[Corner]:
    """Return the corners counter-clockwise and closed, as RFC 7946, 3.1.6 requires for an outer ring."""
    corners = [frame.place(x, y) for x, y in (outline if area_of(outline) > 0.0 else outline[::-1])]
    return [*corners, corners[0]]


def _utc(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="seconds")
