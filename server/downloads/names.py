"""Names of downloaded files: from the log's or world's name, valid on every system, equal in header and yaml."""

from __future__ import annotations

import re
import unicodedata
from urllib.parse import quote

#: pattern of a map snapshot's name, which becomes part of its file names
SNAPSHOT_NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,39}$"
MAX_STEM_BYTES = 150  #: in UTF-8; file systems allow 255 with everything that is added

_ENDINGS = re.compile(r"\.(gz|zst|log|clf|bag|mcap|db3|csv|dat|txt|tar|tgz|relations|yaml|pgm|png)$", re.IGNORECASE)
_UNSAFE = re.compile(r"[^\w.+-]+")  # \w: letters and digits of all scripts
_RESERVED = re.compile(r"(con|prn|aux|nul|(com|lpt)[0-9¹²³])(\..*)?", re.IGNORECASE)  # devices of Windows


def file_stem(title: str) -> str:
    """Return the name of a log or a world as the name of a file without its ending.

    Endings of log files are removed, and characters that are special in shells, URLs or file systems are replaced by
    underscores. An empty result is replaced by "map".
    """
    stem = unicodedata.normalize("NFC", title).strip()
    while _ENDINGS.search(stem):
        stem = _ENDINGS.sub("", stem)
    stem = _UNSAFE.sub("_", stem).strip("._-")
    stem = stem.encode()[:MAX_STEM_BYTES].decode(errors="ignore").rstrip("._-")
    if not stem:
        return "map"
    return f"{stem}_" if _RESERVED.fullmatch(stem) else stem


def file_name(stem: str, ending: str, snapshot: str | None = None, title: str = "") -> str:
    """Return the name of a file; with ``snapshot`` it differs from that of the same map at another instant.

    It never equals ``title``, the name of the log's own file, which it would replace.
    """
    name = f"{stem}{'' if snapshot is None else f'_{snapshot}'}"
    return f"{name}_gridbloom.{ending}" if f"{name}.{ending}" == title else f"{name}.{ending}"


def disposition(name: str) -> str:
    """Return the header Content-Disposition for a file to be saved (RFC 6266), in ASCII for old clients too."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    plain = re.sub(r"[^A-Za-z0-9._+-]", "_", plain)
    plain = f"map{plain}" if plain.startswith(".") else plain
    header = f'attachment; filename="{plain}"'
    return header if plain == name else f"{header}; filename*=UTF-8''{quote(name, safe='')}"
