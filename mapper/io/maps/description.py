"""Parser of the yaml that describes a map image, treated as untrusted input.

Only plain scalars and lists are used. YAML 1.1's interpretation of scalars is not used, because ``1:30`` would be the
number 90 and ``010`` the number 8.
"""

from __future__ import annotations

import math
import re
import unicodedata
from dataclasses import dataclass
from pathlib import Path, PureWindowsPath
from typing import get_args

import yaml

from mapper.core.errors import LimitError, ReadError
from mapper.core.limits import Limits
from mapper.io.maps.writing import FRAME_KEY, Mode
from mapper.io.untrusted_yaml import UntrustedLoader, text_of, where_and_why
from mapper.sensors.georeference import FARTHEST_M

_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?\Z", re.ASCII)
LONGEST_FRAME = 255  #: characters of a frame name
_BOOLEANS = {
    **dict.fromkeys(("0", "false", "no", "off", "n"), False),
    **dict.fromkeys(("1", "true", "yes", "on", "y"), True),
}


@dataclass(frozen=True, slots=True)
class MapDescription:
    """Contents of the yaml: metres, radians; ``image`` is the stated path.

    ``frame`` is the map's frame if the yaml states it, as in files of :func:`mapper.io.maps.save_map`. ``notes`` are
    sentences on values that are ignored, or interpreted differently than expected.
    """

    image: str
    resolution: float
    origin: tuple[float, float, float]
    negate: bool
    occupied_thresh: float
    free_thresh: float
    mode: Mode
    frame: str | None = None
    notes: tuple[str, ...] = ()


class _Loader(UntrustedLoader):
    most_levels = 10  # the yaml of a map has two


def parse_description(data: bytes, limits: Limits) -> MapDescription:
    """Return the contents of a map's yaml. Raises :class:`ReadError`, naming the key, and :class:`LimitError`."""
    if len(data) > limits.max_yaml_bytes:
        raise LimitError(
            "map.yaml_too_large", f"The file has more than {limits.max_yaml_bytes} bytes: it is not the yaml of a map."
        )
    nodes, notes = _top_level(data)
    missing = [
        key for key in ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh") if key not in nodes
    ]
    if missing:
        raise ReadError("map.key_missing", f"The map’s yaml lacks the key {missing[0]!r}.")
    resolution = _number(nodes["resolution"], "resolution")
    if resolution <= 0.0:
        raise ReadError("map.resolution", f"The map’s resolution must be positive, not {resolution:g} m.")
    thresholds = _thresholds(nodes)
    return MapDescription(
        image=_image(nodes["image"]),
        resolution=resolution,
        origin=_origin(nodes["origin"], limits),
        negate=_negate(nodes["negate"]),
        **thresholds,
        mode=_mode(nodes.get("mode")),
        frame=_frame(nodes.get(FRAME_KEY)),
        notes=(*notes, *_note_on_thresholds(**thresholds)),
    )


def _top_level(data: bytes) -> tuple[dict[str, yaml.Node], tuple[str, ...]]:
    """Return the values of the first document by key, and notes; yaml-cpp also reads only this document."""
    try:
        text = text_of(data)
    except UnicodeDecodeError:
        text = data.decode("latin-1")  # yaml-cpp accepts any bytes in comments
    try:
        loader = _Loader(text)
        try:
            root = loader.get_node() if loader.check_node() else None
            is_last = loader.check_event(yaml.StreamEndEvent)
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        raise ReadError("map.yaml", f"The map’s yaml is malformed{where_and_why(error, text)}.") from error
    except yaml.YAMLError as error:
        raise ReadError("map.yaml", "The map’s yaml is malformed: it holds a character that YAML forbids.") from error
    if not isinstance(root, yaml.MappingNode):
        raise ReadError("map.yaml", "The map’s yaml must be a list of keys with values, one on each line.")
    nodes: dict[str, yaml.Node] = {}
    for key, value in root.value:
        name = key.value if isinstance(key, yaml.ScalarNode) else None
        if name is None or name in nodes:
            what = "has a key that is not a word" if name is None else f"has the key {name!r:.40} twice"
            raise ReadError("map.yaml", f"The map’s yaml {what}, in line {key.start_mark.line + 1}.")
        nodes[name] = value
    return nodes, () if is_last else ("The map’s yaml has more documents, after ---: the first is read.",)


def _scalar(node: yaml.Node, key: str) -> str:
    if not isinstance(node, yaml.ScalarNode):
        raise ReadError("map.value", f"The key {key!r} of the map’s yaml needs one value.")
    return str(node.value)


def _number(node: yaml.Node, key: str) -> float:
    text = _scalar(node, key)
    value = float(text) if _NUMBER.match(text) else math.nan
    if not math.isfinite(value):
        raise ReadError("map.value", f"The key {key!r} of the map’s yaml must be a finite number, not {text!r:.40}.")
    return value


def _origin(node: yaml.Node, limits: Limits) -> tuple[float, float, float]:
    if isinstance(node, yaml.ScalarNode) and re.fullmatch(r"\[[^\[\]]*\]", str(node.value)):  # a list in quotes
        items: list[yaml.Node] = [yaml.ScalarNode("", item.strip()) for item in node.value[1:-1].split(",")]
    else:
        items = node.value if isinstance(node, yaml.SequenceNode) else []
    if len(items) != 3:
        raise ReadError("map.origin", "The key 'origin' of the map’s yaml must be a list of three numbers: x, y, yaw.")
    if "nan" in _scalar(items[2], "origin").lower():
        raise ReadError(
            "map.origin",
            "The yaw of the map’s origin is not a number, as map_saver writes where the map’s rotation is invalid: "
            "write 0 in its place.",
        )
    x, y, yaw = (_number(item, "origin") for item in items)
    if max(abs(x), abs(y)) > FARTHEST_M or abs(yaw) > limits.max_pose:
        raise ReadError("map.origin", f"The map’s origin {x:g}, {y:g}, {yaw:g} is beyond {FARTHEST_M:g} m.")
    return (x, y, yaw)


def _thresholds(nodes: dict[str, yaml.Node]) -> dict[str, float]:
    occupied, free = (_number(nodes[key], key) for key in ("occupied_thresh", "free_thresh"))
    if not (0.0 <= free <= 1.0 and 0.0 <= occupied <= 1.0):
        raise ReadError(
            "map.thresholds",
            f"The map’s thresholds free_thresh and occupied_thresh must be 0 … 1, not {free:g} and {occupied:g}.",
        )
    return {"occupied_thresh": occupied, "free_thresh": free}


def _note_on_thresholds(occupied_thresh: float, free_thresh: float) -> tuple[str, ...]:
    if free_thresh < occupied_thresh:
        return ()
    note = (
        f"free_thresh, {free_thresh:g}, is not below occupied_thresh, {occupied_thresh:g}: as in nav2_map_server what "
        "is above the latter is occupied, and nothing between them is unknown."
    )
    return (note,)


def _negate(node: yaml.Node) -> bool:
    text = _scalar(node, "negate")
    if text.lower() not in _BOOLEANS:
        raise ReadError("map.value", f"The key 'negate' of the map’s yaml must be 0 or 1, not {text!r:.40}.")
    return _BOOLEANS[text.lower()]


def _mode(node: yaml.Node | None) -> Mode:
    text = "trinary" if node is None else _scalar(node, "mode")
    for mode in get_args(Mode):
        if text.lower() == mode:  # compared as in nav2_map_server
            return mode  # type: ignore[no-any-return] # get_args gives Any
    raise ReadError("map.mode", f"The map’s mode must be trinary, scale or raw, not {text!r:.40}.")


def _frame(node: yaml.Node | None) -> str | None:
    if node is None:
        return None
    name = _scalar(node, FRAME_KEY)
    if not name or not name.isprintable() or len(name) > LONGEST_FRAME:
        raise ReadError("map.frame", f"The key {FRAME_KEY!r} of the map’s yaml must name a frame, not {name!r:.40}.")
    return name


def _image(node: yaml.Node) -> str:
    name = _scalar(node, "image")
    if not name or "\0" in name:
        raise ReadError("map.image_name", f"The map’s yaml names no image: {name!r:.40}.")
    return name


def _folded(name: str) -> str:
    return unicodedata.normalize("NFC", name).casefold()


def image_path(yaml_path: Path, name: str) -> tuple[Path, str | None]:
    """Return the path of the image, and a note if it differs from the one in the yaml.

    A file outside the yaml's folder is never read, whether by its path or through a link. If the stated file is outside
    or missing, the file of the same base name next to the yaml is used: maps are moved together with their image, while
    the path in the yaml stays that of the other computer. Without such a file, one whose name differs only in case is
    used, as on case-insensitive file systems. Raises :class:`ReadError`.
    """
    folder = yaml_path.parent
    base = PureWindowsPath(name).name  # its separators are / and \
    try:
        root = folder.resolve()
        named = folder / name
        is_inside = named.resolve().is_relative_to(root)
        if is_inside and named.is_file():
            return named, None
        beside = folder / base
        if base and not beside.is_file():
            alike = [path for path in folder.iterdir() if _folded(path.name) == _folded(base) and path.is_file()]
            beside = alike[0] if len(alike) == 1 else beside
        has_beside = bool(base) and beside.is_file()
        if has_beside and beside.resolve().is_relative_to(root):
            note = f"{beside.name!r:.80} beside the yaml is read in its place."
            return beside, f"The yaml names the image {name!r:.120}; {note}"
    except (OSError, ValueError, RuntimeError) as error:  # a loop of links, or a name that is too long
        raise ReadError("map.image_missing", f"The image {name!r:.80} of the map cannot be found.") from error
    if has_beside:
        raise ReadError("map.image_outside", f"The map’s image {base!r:.80} is a link that leaves the folder.")
    where = "which does not exist" if is_inside else "outside the yaml’s own folder"
    also = f", and there is no {base!r:.80} beside the yaml" if base and base != name else ""
    code = "map.image_missing" if is_inside else "map.image_outside"
    raise ReadError(code, f"The map’s yaml names the image {name!r:.80}, {where}{also}.")
