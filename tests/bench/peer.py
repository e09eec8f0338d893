"""The peers to compare with: other programs, built from the folder that GRIDBLOOM_PEERS names."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from mapper.sensors.scan import ScanLog

LIBRARIES = [
    "maps",
    "obs",
    "poses",
    "math",
    "core",
    "serialization",
    "rtti",
    "io",
    "containers",
    "system",
    "config",
    "img",
    "opengl",
]


class PeerAbsentError(Exception):
    """The peer cannot be built here; the message says why."""


def peers_dir() -> Path:
    return Path(os.environ.get("GRIDBLOOM_PEERS", "../shared/peers"))


def versions() -> str:
    """Return the versions of Python, of what the kernels stand on, and of the peers that are installed, in one line."""
    found = {name: _package(name) for name in ("numpy", "numba", "small_gicp", "pyoctomap", "rosbags", "mcap")}
    found["Open3D"] = _answer(os.environ.get("GRIDBLOOM_OPEN3D", ""), "-c", "import open3d; print(open3d.__version__)")
    found["MRPT"] = _answer("dpkg-query", "--show", "--showformat=${Version}", "libmrpt-maps-dev")
    return ", ".join([f"Python {platform.python_version()}", *(f"{name} {one}" for name, one in found.items())])


def _package(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"


def _answer(*command: str) -> str:
    """Return the last line that a program prints; "absent" where there is none, or where it fails."""
    if shutil.which(command[0]) is None:
        return "absent"
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    lines = done.stdout.split()
    return lines[-1] if done.returncode == 0 and lines else "absent"


def build_mrpt(into: Path) -> Path:
    """Build the program that times MRPT's scan insertion; return it."""
    source = peers_dir() / "mrpt_insert.cpp"
    if not source.is_file():
        raise PeerAbsentError("no mrpt_insert.cpp in the folder that GRIDBLOOM_PEERS names")
    return _built(source, into, LIBRARIES)


def build_mrpt_localizer(into: Path) -> Path:
    """Build the program that times an update of MRPT's Monte Carlo localization; return it."""
    return _built(Path(__file__).with_name("mrpt_localize.cpp"), into, ["slam", "bayes", *LIBRARIES])


def _built(source: Path, into: Path, libraries: list[str]) -> Path:
    headers = Path("/usr/include/mrpt")
    compiler = shutil.which("g++")
    if compiler is None:
        raise PeerAbsentError("no g++")
    if not headers.is_dir():
        raise PeerAbsentError("no MRPT: apt-get install libmrpt-maps-dev libmrpt-obs-dev libmrpt-slam-dev")
    program = into / source.stem
    includes = [f"-I{folder}" for folder in sorted(headers.glob("*/include"))]
    command = [compiler, "-O3", "-march=native", "-std=c++17", str(source), "-o", str(program), *includes]
    command += ["-I/usr/include/eigen3", *(f"-lmrpt-{name}" for name in libraries)]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    if built.returncode != 0:
        raise PeerAbsentError("MRPT's program does not build: " + built.stderr.strip().splitlines()[-1])
    return program


def pack(log: ScanLog, range_max: float, path: Path) -> None:
    """Write a log as the peer reads it."""
    poses = log.sensor_poses()
    with path.open("wb") as file:
        file.write(np.array([log.n_scans, log.n_beams], dtype="<i4").tobytes())
        file.write(np.array([log.angle_min, log.angle_increment, range_max], dtype="<f8").tobytes())
        for pose, ranges in zip(poses, log.ranges, strict=True):
            file.write(pose.astype("<f8").tobytes())
            file.write(ranges.astype("<f4").tobytes())


def mrpt_ms(program: Path, log: ScanLog, range_max: float, resolution: float) -> float:
    """Return the peer's milliseconds for the whole log, best of its five passes."""
    packed = program.with_name("scans.bin")
    pack(log, range_max, packed)
    done = subprocess.run([str(program), str(packed), str(resolution)], capture_output=True, text=True, check=True)
    return float(done.stdout)
