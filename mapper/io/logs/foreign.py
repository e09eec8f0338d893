"""Identification, by their first bytes, of files that are mistaken for logs."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

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
#: Added for every file of unknown kind.
READ_HERE = f"Read are logs ({KNOWN}) and clouds ({KNOWN_3D})."

AS_CLOUD = "save its points as PLY, LAS or PCD, as CloudCompare does"
AS_TEXT = "save its points as text, numpy.savetxt('cloud.xyz', points[:, :3])"
HEIGHTS = "of a map, open the yaml that names it; heights, save as points x, y, z"
PACKETS = (
    "packets of a network, PCAP, as of a lidar (replay them to the lidar’s ROS driver and record its clouds in a bag, "
    "or save them as CSV or PCD with the maker’s viewer)"
)
PBSTREAM = (
    "a state of Cartographer, .pbstream (its map is written by cartographer_pbstream_to_ros_map; a log is the bag that "
    "it was made of)"
)
POSEGRAPH = (
    "data of a program that Boost serialised, as slam_toolbox does its .posegraph and .data (load it there, and save "
    "its map with map_saver; a log is the bag that it was made of)"
)
#: First bytes of files that are not text logs, and their description.
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
    (b"MATLAB 5.0 MAT-file", "a file of MATLAB (save its points as text, x, y and z in each line)"),
    (b"PAR1", "a table in the format Parquet (save its columns x, y and z as CSV)"),
    (b"II*\0", f"a TIFF picture, or heights as GeoTIFF ({HEIGHTS})"),
    (b"MM\0*", f"a TIFF picture, or heights as GeoTIFF ({HEIGHTS})"),
    (b"\xdb\x01\xf5\x5b\x7b\x1f\x1d\x7b", PBSTREAM),
    (b"\x16\0\0\0\0\0\0\0serialization::archive", POSEGRAPH),
    *(
        (magic, PACKETS)
        for magic in (
            b"\xd4\xc3\xb2\xa1",
            b"\xa1\xb2\xc3\xd4",
            b"\x4d\x3c\xb2\xa1",
            b"\xa1\xb2\x3c\x4d",
            b"\x0a\x0d\x0d\x0a",
        )
    ),
    (b"livox_tech", "a recording of Livox Viewer, LVX (livox_ros_driver plays it: record its clouds in a bag)"),
    (b"RRF2", "a recording of Rerun, .rrd (record the topics in a bag or an MCAP file)"),
    (b"ULog", "a flight log of PX4, ULog, which has no scans"),
    (b"\xa3\x95\x80", "a flight log of ArduPilot, DataFlash, which has no scans"),
    (b"\x93NUMPY", f"an array of NumPy ({AS_TEXT})"),
    (b"\x37\x7f\x06\x82", "the write-ahead log of an SQLite file, of no use without the .db3"),
    (b"\x37\x7f\x06\x83", "the write-ahead log of an SQLite file, of no use without the .db3"),
)

#: Beginnings of texts that are neither logs nor supported clouds, and their description.
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
    (
        re.compile(rb"version https://git-lfs\.github\.com/spec/"),
        "a pointer of Git LFS in place of the file (git lfs pull fetches it)",
    ),
    (
        re.compile(rb"[./]*(?:\.git)?/annex/objects/"),
        "a pointer of git-annex in place of the file (git annex get fetches it)",
    ),
    (
        re.compile(rb"\s*<(?:!doctype html|html)\b", re.IGNORECASE),
        "a page of HTML, as servers send in place of a file (download the file itself)",
    ),
    (
        re.compile(rb"(?:<\?xml[^>]*\?>\s*)?<VTKFile\b"),
        f"a file of VTK in XML ({AS_CLOUD}; VTK’s legacy format is read)",
    ),
    (re.compile(rb"ncols\s+\d+", re.IGNORECASE), f"a grid of heights of ESRI ({AS_CLOUD})"),
)
#: Beginnings of zip archives that are one document, and their description.
ZIPPED: tuple[tuple[re.Pattern[bytes], str], ...] = (
    (re.compile(rb"PK\x03\x04.{26}[^/\0]{1,200}\.npy", re.DOTALL), f"an archive of arrays of NumPy ({AS_TEXT})"),
    (
        re.compile(rb"PK\x03\x04.{26}(?:\[Content_Types\]|_rels/|docProps/)", re.DOTALL),
        "a document of an office program, as a workbook of Excel (save its sheet as CSV)",
    ),
    (
        re.compile(rb"PK\x03\x04.{26}mimetypeapplication/vnd\.oasis", re.DOTALL),
        "a document of an office program, as a sheet of LibreOffice (save it as CSV)",
    ),
)
#: Archives of several files: offset of the magic bytes, the magic bytes, and the description.
ARCHIVES: tuple[tuple[int, bytes, str], ...] = (
    (0, b"PK\x03\x04", "a zip archive"),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7z archive"),
    (0, b"Rar!", "a rar archive"),
    (257, b"ustar", "a tar archive"),
)
MAP = "log.map"  #: of the error for a map's yaml
#: Lines of yaml files that accompany logs, and their description.
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
POSE_LINES = 20  #: lines of a text examined for a trajectory
NEARLY = 0.05  #: tolerance of the length of a quaternion or axis around 1
#: Formats of trajectories, and how to use such a file.
TRAJECTORIES = {
    "TUM": (
        "Add it to the log that it belongs to: on the page of the log, or with --tum-trajectory on the command line."
    ),
    "KITTI": (
        "It states no times: evo's kitti_poses_and_timestamps_to_trajectory.py makes it a TUM file, which can be added "
        "to the log, and with which map3d --poses places clouds."
    ),
    "EuRoC": "evo_traj euroc FILE --save_as_tum makes it a TUM file, which can be added to the log.",
    "NCLT": "Write its lines as TUM has them, seconds x y z qx qy qz qw: a TUM file can be added to the log.",
}


def trajectory_format(head: bytes) -> str | None:
    """Return the trajectory format of a text, a key of :data:`TRAJECTORIES`; None for other texts.

    ``head`` is the beginning of the file; its last line, which may be cut, is ignored.
    """
    lines = [line for line in head.split(b"\n")[:-1] if line.strip() and not line.lstrip().startswith(b"#")]
    if len(lines) > 1 and not re.search(rb"\d", lines[0]):  # column names
        lines = lines[1:]
    formats = {_format_of_pose(line) for line in lines[:POSE_LINES]}
    if formats == {"TUM"}:  # as opposed to points with normals, whose length is also 1
        times = [float(re.split(rb"[,\s]", line.strip(), maxsplit=1)[0]) for line in lines[:POSE_LINES]]
        return "TUM" if times == sorted(times) else None
    return formats.pop() if len(formats) == 1 else None


def _format_of_pose(line: bytes) -> str | None:
    """Return the format of a line with one pose, None for another line.

    A TUM line has eight numbers, separated by blanks or commas, the last four a unit quaternion; a KITTI line the first
    three rows of a matrix; EuRoC and NCLT lines start with nanoseconds and microseconds and have commas, with a
    quaternion from the fifth number on, or three angles at the end.
    """
    has_commas = b"," in line
    line = line.rstrip(b", \r")
    try:
        numbers = [float(word) for word in (line.split(b",") if has_commas else line.split())]
    except ValueError:
        return None
    if has_commas:
        if len(numbers) >= 8 and numbers[0] > 1e17 and _is_unit(numbers[4:8]):
            return "EuRoC"
        if len(numbers) == 7 and 1e14 < numbers[0] < 1e17:
            return "NCLT"
    if len(numbers) == 8 and _is_unit(numbers[4:]):
        return "TUM"
    axes = numbers[0:3], numbers[4:7], numbers[8:11]
    return "KITTI" if len(numbers) == 12 and all(map(_is_unit, axes)) else None


def _is_unit(numbers: Sequence[float]) -> bool:
    return abs(math.hypot(*numbers) - 1.0) <= NEARLY


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
    """Return the kind of archive that starts with ``head``; None if it is not an archive."""
    return next((what for at, mark, what in ARCHIVES if head.startswith(mark, at)), None)


def zipped_document(head: bytes) -> str | None:
    """Return the kind of document in a zip archive that starts with ``head``; None for archives of files and other
    kinds.
    """
    return next((what for pattern, what in ZIPPED if pattern.match(head)), None)


def what_else(head: bytes) -> str | None:
    """Return the description of a file that is neither log nor cloud and starts with ``head``; None if unknown."""
    document = zipped_document(head)
    if document is not None:
        return document
    archive = archive_of(head)
    if archive is not None:
        return f"{archive} (unpack it, and open the file in it)"
    known = next((what for magic, what in FOREIGN if head.startswith(magic)), None)
    return known or next((what for pattern, what in FOREIGN_TEXT if pattern.match(head)), None)


def not_a_log(head: bytes) -> ReadError:
    """Return the error describing a file that starts with ``head`` and is not a log."""
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
    trajectory = trajectory_format(head)
    if trajectory is not None:
        what = f"The file is a trajectory in the format {trajectory}, without scans."
        return ReadError("log.poses", f"{what} {TRAJECTORIES[trajectory]}")
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
