"""What a file is that is taken for a log and is none, by its first bytes."""

from __future__ import annotations

import math
import re

from mapper.core.errors import ReadError
from mapper.io.logs.archives.inflate import ZSTD_MAGIC
from mapper.io.logs.archives.unpacking import GZIP_MAGIC
from mapper.io.logs.text import sonar
from mapper.io.logs.text.lines import BOM

OLD_BAGS = (b"#ROSRECORD V", b"#ROSLOG V")  #: first bytes of ROS 1 bags before format 2.0
KNOWN = "CARMEN, CMU, ROS 1 bag, ROS 2 bag (SQLite), MCAP, DP-SLAM, gmapping (.gfs), BreezySLAM, a sonar ring or CSV"
KNOWN_3D = (
    "PCD, PLY, VTK, LAS, LAZ, XYZ, PTS, CSV, points of KITTI and nuScenes (.bin), a scan graph, an octree (.bt, .ot) "
    "or a zip of depth images"
)
#: What every file of an unknown kind is told.
READ_HERE = f"Read are logs ({KNOWN}) and clouds ({KNOWN_3D})."

AS_CLOUD = "save its points as PLY, LAS or PCD, as CloudCompare does"
AS_TEXT = "save its points as text, numpy.savetxt('cloud.xyz', points[:, :3])"
#: First bytes of files that are no text log, and what they are.
FOREIGN: tuple[tuple[bytes, str], ...] = (
    (b"BZh", "bzip2 data (unpack it)"),
    (b"\xfd7zXZ\0", "xz data (unpack it)"),
    (b"\x04\x22\x4d\x18", "lz4 data (unpack it)"),
    (b"\x5d\0\0", "lzma data (unpack it)"),
    (b"\x89PNG\r\n", "a PNG picture (of a map, open the yaml that names it)"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"BM", "a BMP picture"),
    (b"P5", "a PGM picture (of a map, open the yaml that names it)"),
    (b"%PDF", "a PDF document"),
    (b"\xff\xfe", "text in UTF-16, as some Windows programs write it (save it as UTF-8)"),
    (b"\xfe\xff", "text in UTF-16 (save it as UTF-8)"),
    (GZIP_MAGIC, "gzip data within packed data (unpack it once)"),
    (ZSTD_MAGIC, "Zstandard data within packed data (unpack it once)"),
    (b"ASTM-E57", f"an E57 file ({AS_CLOUD})"),
    (b"glTF", f"a scene in binary glTF ({AS_CLOUD})"),
    (b"solid ", f"a mesh in the format STL ({AS_CLOUD})"),
    (b"OFF\n", f"a mesh in the format OFF ({AS_CLOUD})"),
    (b"\x89HDF", "an HDF5 file"),
    (b"\x93NUMPY", f"an array of NumPy ({AS_TEXT})"),
    (b"\x37\x7f\x06\x82", "the write-ahead log of an SQLite file, of no use without the .db3"),
    (b"\x37\x7f\x06\x83", "the write-ahead log of an SQLite file, of no use without the .db3"),
)

#: How texts begin that are neither logs nor clouds that are read, and what they are.
_NUMBERS = rb"[-+.\deE]+"
FOREIGN_TEXT: tuple[tuple[re.Pattern[bytes], str], ...] = (
    (
        re.compile(rb"(?:[ \t]*(?:#[^\n]*)?\r?\n|(?:mtllib|o|g)[ \t][^\n]*\n)*v[ \t]+[-+.\d]"),
        f"a mesh in the format OBJ ({AS_CLOUD})",
    ),
    (
        re.compile(
            rb"\d+\s+\d+\s*\n(?:%b[ \t]+%b[ \t]+%b\s*\n){4}(?:%b[ \t]+%b[ \t]+%b[ \t]+%b\s*\n){4}" % ((_NUMBERS,) * 7)
        ),
        f"a scan in the format PTX of Leica ({AS_CLOUD})",
    ),
    (
        re.compile(rb"%time,field\."),
        "a table of one topic, as rostopic echo -p prints it (record the topics in a bag, those of poses as well)",
    ),
    (
        re.compile(rb"(?:---\s*)?header:\s*\n\s+(?:seq|stamp):"),
        "messages as text, as ros2 topic echo prints them (record the topics in a bag, those of poses as well)",
    ),
    (re.compile(rb"ncols\s+\d+", re.IGNORECASE), f"a grid of heights of ESRI ({AS_CLOUD})"),
)
NPZ = re.compile(rb"PK\x03\x04.{26}[^/\0]{1,200}\.npy", re.DOTALL)  #: a zip archive whose first file is an array
#: Archives of several files: offset of the magic bytes, the magic bytes, and what they are.
ARCHIVES: tuple[tuple[int, bytes, str], ...] = (
    (0, b"PK\x03\x04", "a zip archive"),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
    (0, b"Rar!", "a rar archive"),
    (257, b"ustar", "a tar archive"),
)
MAP = "log.map"  #: of the error for the yaml of a map
#: Lines of yaml files that belong to logs and are none, and what such a file is.
YAML: tuple[tuple[re.Pattern[bytes], str, str], ...] = (
    (
        re.compile(rb"^rosbag2_bagfile_information\s*:", re.MULTILINE),
        "log.metadata",
        "The file describes a ROS 2 bag and holds none of its messages: open the bag’s folder.",
    ),
    (
        re.compile(rb"^\s+[\"']?ros__parameters[\"']?\s*:|[{,]\s*[\"']?ros__parameters[\"']?\s*:", re.MULTILINE),
        "log.parameters",
        "The file has parameters of ROS nodes, not a log: gridbloom costmap, path and localize take it (--params).",
    ),
    (
        re.compile(rb"^[\"']?image[\"']?\s*:", re.MULTILINE),
        MAP,
        "The file describes a map, not a log: gridbloom info and view show it, and the page edits it.",
    ),
)
GRAPH_WORDS = (b"VERTEX_SE2", b"EDGE_SE2", b"VERTEX_SE3:QUAT", b"EDGE_SE3:QUAT")  #: of g2o's lines
TUM_LINES = 20  #: lines of a text that tell whether it is a trajectory
TUM_NORM = 0.05  #: how far from 1 the length of a quaternion may be


def is_tum(head: bytes) -> bool:
    """Return whether a text begins as a TUM trajectory: eight numbers a line, the last four a unit quaternion.

    ``head`` is the beginning of the file; of its last line, which may be cut, nothing is read.
    """
    lines = [line for line in head.split(b"\n")[:-1] if line.strip() and not line.lstrip().startswith(b"#")]
    return bool(lines) and all(_is_tum_line(line) for line in lines[:TUM_LINES])


def _is_tum_line(line: bytes) -> bool:
    try:
        numbers = [float(word) for word in line.split()]
    except ValueError:
        return False
    return len(numbers) == 8 and abs(math.hypot(*numbers[4:]) - 1.0) <= TUM_NORM


def _old_bag(head: bytes) -> ReadError:
    """Return the error for a bag of a format before 2.0. Source: wiki.ros.org/Bags/Format; rosbag's own readers."""
    version = head.split(b"\n")[0][:20].decode("latin-1").strip()
    convert = "rosbag of ROS 1 converts it: rosbag filter OLD.bag NEW.bag True."
    if version != "#ROSRECORD V1.2":
        convert = "The rosbag of ROS C Turtle is the last that reads it: rosbag filter OLD.bag NEW.bag True."
    return ReadError(
        "log.version",
        f"The file is a ROS 1 bag of an old format ({version}), which ROS wrote before 2010; format 2.0 is read here. "
        f"{convert}",
    )


def archive_of(head: bytes) -> str | None:
    """Return what kind of archive begins with ``head``; None where none does."""
    return next((what for at, mark, what in ARCHIVES if head.startswith(mark, at)), None)


def what_else(head: bytes) -> str | None:
    """Return what a file is that begins with ``head`` and is neither a log nor a cloud; None where it is not known."""
    if NPZ.match(head):
        return f"an archive of arrays of NumPy ({AS_TEXT})"
    archive = archive_of(head)
    if archive is not None:
        return f"{archive} (unpack it, and open the file in it)"
    known = next((what for magic, what in FOREIGN if head.startswith(magic)), None)
    return known or next((what for pattern, what in FOREIGN_TEXT if pattern.match(head)), None)


def not_a_log(head: bytes) -> ReadError:
    """Return the error that says what a file is that begins with ``head`` as no log does."""
    head = head.removeprefix(BOM)
    if not head:
        return ReadError("log.empty", "The file is empty.")
    if head.startswith(OLD_BAGS):
        return _old_bag(head)
    foreign = what_else(head)
    if foreign is not None:
        return ReadError("log.unknown_format", f"The file is {foreign}. {READ_HERE}")
    if b"\0" in head:
        return ReadError("log.binary", f"The file is binary data of an unknown kind. {READ_HERE}")
    if sonar.is_sonar_poses(head):
        return ReadError(
            "log.poses",
            f"The file is poses without readings, four whole numbers a line: a ring of sonars is {sonar.READINGS} and "
            f"{sonar.POSES} together, or the folder or tar archive that they are in.",
        )
    if is_tum(head):
        return ReadError(
            "log.poses",
            "The file is a trajectory in the format TUM, without scans. Add it to the log that it belongs to: on the "
            "page of the log, or with --tum-trajectory on the command line.",
        )
    if head.lstrip().startswith(GRAPH_WORDS):
        return ReadError("log.poses", "The file is a pose graph in the format g2o, without scans: open its log.")
    for pattern, code, what in YAML:
        if pattern.search(head):
            return ReadError(code, what)
    lines = [line for line in head.split(b"\n") if line.strip()]
    if all(line.lstrip().startswith(b"#") for line in lines):
        return ReadError("log.no_scans", "The log holds no scans: it has nothing but comments and empty lines.")
    return ReadError(
        "log.unknown_format",
        f"The file is of no known kind: it starts with {lines[0][:40].decode('latin-1')!r}. {READ_HERE}",
    )
