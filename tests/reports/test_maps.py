"""Map files as people have them, beside what nav2_map_server makes of each; one case of each kind.

A test names the report that its situation is known from; those without one are of the same kinds.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from mapper.core.errors import ReadError
from mapper.editing import EditedMap
from mapper.editing.files import edits_text
from mapper.grid import GridGeometry
from mapper.io.logs import open_log
from mapper.io.maps import load_map
from tests.server.cli.running import Run

GREYS = np.array([[0, 205, 254, 254], [0, 254, 254, 205]], dtype=np.uint8)  # the upper row first
VALUES = [[100, 0, 0, -1], [100, -1, 0, 0]]


def written(
    folder: Path, image: str = "room.pgm", *, mode: str = "trinary", free_thresh: float = 0.196, times: int = 1
) -> Path:
    """Write room.yaml, which names ``image``, and room.pgm beside it, each of whose cells is ``times`` × ``times``."""
    folder.mkdir(exist_ok=True)
    Image.fromarray(np.kron(GREYS, np.ones((times, times), np.uint8))).save(folder / "room.pgm")
    path = folder / "room.yaml"
    path.write_text(
        f"image: '{image}'\nresolution: 0.5\norigin: [0, 0, 0]\nnegate: 0\nmode: {mode}\n"
        f"occupied_thresh: 0.65\nfree_thresh: {free_thresh}\n"
    )
    return path


ELSEWHERE = (
    "/home/anna/maps/room.pgm", "maps/room.pgm", "../room.pgm", "C:\\Users\\anna\\room.pgm", "~/room.pgm",
    "$(find my_maps)/maps/room.pgm", "file:///tmp/room.pgm",
)  # fmt: skip


@pytest.mark.parametrize("image", ELSEWHERE)
def test_an_image_that_is_named_elsewhere_is_the_one_beside_the_yaml(tmp_path: Path, image: str) -> None:
    """navigation#31, navigation#1004, turtlebot3#267: a path of another computer."""
    (tmp_path / "room.pgm").write_bytes(b"P5\n1 1\n255\n\0")  # outside the yaml's folder: not to be read
    loaded = load_map(written(tmp_path / "inside", image))
    assert loaded.values.tolist() == VALUES
    assert loaded.notes == (f"The yaml names the image {image!r}; 'room.pgm' beside the yaml is read in its place.",)


@pytest.mark.parametrize("head", [b"Pf\n2 1\n-1.0\n", b"P7\nWIDTH 2\nHEIGHT 1\nDEPTH 4\nMAXVAL 255\nENDHDR\n"])
def test_images_that_only_begin_as_those_of_netpbm_are_refused(tmp_path: Path, head: bytes) -> None:
    """Of floats, 0 … 1, all cells were occupied."""
    path = written(tmp_path)
    (tmp_path / "room.pgm").write_bytes(head + np.array([0.0, 1.0], "<f4").tobytes())
    with pytest.raises(ReadError, match="is not a PGM, PNG or BMP image"):
        load_map(path)


@pytest.mark.parametrize("image", ["room.pgm", "./room.pgm", "../inside/room.pgm"])
def test_an_image_of_the_folder_has_no_note(tmp_path: Path, image: str) -> None:
    assert load_map(written(tmp_path / "inside", image)).notes == ()


def test_an_absolute_path_into_the_folder_is_followed(tmp_path: Path) -> None:
    path = written(tmp_path, str(tmp_path / "images" / "other.pgm"))
    (tmp_path / "images").mkdir()
    Image.fromarray(GREYS[:, ::-1]).save(tmp_path / "images" / "other.pgm")
    loaded = load_map(path)
    assert (loaded.values.tolist(), loaded.notes) == ([row[::-1] for row in VALUES], ())


@pytest.mark.parametrize("image", ["{}/secret.pgm", "../secret.pgm", "link.pgm", "/somewhere/link.pgm"])
def test_no_file_outside_the_folder_is_read(tmp_path: Path, image: str) -> None:
    secret = tmp_path / "secret.pgm"
    secret.write_bytes(b"P5\n1 1\n255\n\0")
    path = written(tmp_path / "inside", image.format(tmp_path))
    (tmp_path / "inside" / "link.pgm").symlink_to(secret)
    with pytest.raises(ReadError) as refused:
        load_map(path)
    assert refused.value.code == "map.image_outside"


@pytest.mark.parametrize("yaw", ["-nan", ".nan", "nan"])
def test_a_yaw_that_is_no_number_says_what_to_write(tmp_path: Path, yaw: str) -> None:
    """ros-planning/navigation#993: map_saver, of a map whose rotation was an invalid quaternion."""
    path = written(tmp_path)
    path.write_text(path.read_text().replace("[0, 0, 0]", f"[0.5, -1.0, {yaw}]"))
    with pytest.raises(ReadError, match="write 0 in its place"):
        load_map(path)


def again(path: Path, was: str, now: str) -> tuple[list[list[int]], tuple[str, ...]]:
    """Return the values and notes of a map whose yaml has ``now`` in place of ``was``."""
    path.write_text(path.read_text().replace(was, now))
    loaded = load_map(path)
    return loaded.values.tolist(), loaded.notes


@pytest.mark.parametrize(("named", "there"), [("room.PGM", "room.pgm"), ("r\u00fc.pgm", "Ru\u0308.PGM")])
def test_an_image_whose_name_differs_in_capitals_is_the_one_beside(tmp_path: Path, named: str, there: str) -> None:
    """As on Windows and macOS, whose file names are alike then, and whose umlauts are two characters."""
    path = written(tmp_path, named)
    (tmp_path / "room.pgm").rename(tmp_path / there)
    assert load_map(path).values.tolist() == VALUES
    assert f"{there!r} beside the yaml is read in its place" in load_map(path).notes[0]
    (tmp_path / there.upper()).write_bytes(b"")
    with pytest.raises(ReadError, match="which does not exist"):  # one of two
        load_map(path)


def test_a_path_of_windows_in_double_quotes_says_what_is_wrong(tmp_path: Path) -> None:
    r"""In YAML ``\m`` is no escape, and yaml-cpp refuses it too."""
    path = written(tmp_path)
    path.write_text(path.read_text().replace("'room.pgm'", r'"C:\maps\room.pgm"'))
    with pytest.raises(ReadError, match="in line 1: a backslash within double quotes begins an escape: put single"):
        load_map(path)


@pytest.mark.parametrize(("word", "is_negated"), [("on", True), ("Y", True), ("off", False), ("N", False)])
def test_negate_is_each_word_of_yaml_cpp(tmp_path: Path, word: str, is_negated: bool) -> None:
    values, _ = again(written(tmp_path, free_thresh=0.1), "negate: 0", f"negate: {word}")
    expected = np.where(GREYS > 166, 100, 0) if is_negated else np.where(GREYS == 0, 100, np.where(GREYS > 230, 0, -1))
    assert values == expected[::-1].tolist()


@pytest.mark.parametrize("mode", ["trinary", "scale"])
@pytest.mark.parametrize(("occupied", "free"), [(0.1, 0.6), (0.5, 0.5)])
def test_thresholds_in_the_other_order_are_compared_as_map_server_does(
    tmp_path: Path, mode: str, occupied: float, free: float
) -> None:
    """loadMapFromFile of nav2_map_server compares with occupied_thresh first."""
    path = written(tmp_path, mode=mode, free_thresh=free)
    values, notes = again(path, "occupied_thresh: 0.65", f"occupied_thresh: {occupied}")
    assert values == np.where(occupied < 1.0 - GREYS / 255.0, 100, 0)[::-1].tolist()
    assert notes[0].startswith(
        f"free_thresh, {free:g}, is not below occupied_thresh, {occupied:g}: as in nav2_map_server"
    )


def test_forms_of_a_yaml_that_other_programs_write(tmp_path: Path) -> None:
    path = written(tmp_path)
    assert again(path, "[0, 0, 0]", "'[0, 0, 0]'") == (VALUES, ())
    text = path.read_text()
    for data in (text.encode("utf-16"), b"# r\xe4ume\n" + text.encode()):
        path.write_bytes(data)
        assert load_map(path).values.tolist() == VALUES
    path.write_text(f"{text}---\nimage: other.pgm\n")
    loaded = load_map(path)
    assert loaded.values.tolist() == VALUES
    assert loaded.notes == ("The map’s yaml has more documents, after ---: the first is read.",)


@pytest.mark.parametrize("kind", ["P4", "P5", "P6"])
@pytest.mark.parametrize("most", [b"", b"254\r\n", b"65535\r\n"])
def test_lines_of_a_header_may_end_as_on_windows(tmp_path: Path, kind: str, most: bytes) -> None:
    """The line feed after the carriage return was the first pixel, and all others stood one byte to the right."""
    pixels = GREYS == 0 if kind == "P4" else np.where(GREYS == 0, 0, 254)
    if kind == "P4":
        body, most = np.packbits(pixels, axis=1).tobytes(), b""
    else:
        scaled = pixels * 257 if most.startswith(b"6") else pixels
        channels = np.stack([scaled] * (3 if kind == "P6" else 1), axis=-1)
        body = channels.astype(">u2" if most.startswith(b"6") else "u1").tobytes()
        most = most or b"255\r\n"
    path = written(tmp_path)
    (tmp_path / "room.pgm").write_bytes(kind.encode() + b"\r\n4 2\r\n" + most + body)
    expected = np.where(GREYS == 0, 100, 0)[::-1].tolist()
    assert load_map(path).values.tolist() == expected
    (tmp_path / "room.pgm").write_bytes(kind.encode() + b"\n4 2\n" + most.replace(b"\r", b"") + body)
    assert load_map(path).values.tolist() == expected


@pytest.mark.parametrize("mode", ["Trinary", "TRINARY", "trinary"])
def test_a_mode_may_have_capitals(tmp_path: Path, mode: str) -> None:
    """map_mode_from_string of nav2_map_server."""
    loaded = load_map(written(tmp_path, mode=mode))
    assert (loaded.description.mode, loaded.values.tolist()) == ("trinary", VALUES)


PICTURES: dict[str, tuple[Any, float, float]] = {
    "grey": (GREYS, 0.25, 0.196),
    "grey of 16 bits": (GREYS.astype(np.uint16) * 257, 0.25, 0.196),
    "colours": (np.stack([GREYS] * 3, axis=-1), 0.25, 0.196),
    "grey and alpha": (np.stack([GREYS, np.full_like(GREYS, 255)], axis=-1), 0.196, 0.147),
    "colours and alpha": (np.stack([GREYS] * 3 + [np.full_like(GREYS, 255)], axis=-1), 0.196, 0.147),
}


@pytest.mark.parametrize("kind", PICTURES)
def test_unknown_that_counts_as_free_has_a_note_with_the_remedy(tmp_path: Path, kind: str) -> None:
    """stdr_simulator#161: an alpha channel."""
    pixels, free_thresh, remedy = PICTURES[kind]
    path = written(tmp_path, "room.png", free_thresh=free_thresh)
    Image.fromarray(pixels).save(tmp_path / "room.png")
    loaded = load_map(path)
    assert (loaded.values == -1).sum() == 0
    (note,) = loaded.notes
    assert note.startswith("Grey 205, which map_saver writes for unknown, counts as free here")
    assert f"{remedy:g}" in note
    cured = written(tmp_path, "room.png", free_thresh=remedy)
    assert ((load_map(cured).values == -1).sum(), load_map(cured).notes) == (2, ())


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_three_greys_in_mode_scale_have_a_note(tmp_path: Path, depth: type) -> None:
    """nav2_map_server knows unknown in mode scale only by alpha, and map_saver's PGM has none."""
    path = written(tmp_path, "room.png", mode="scale")
    Image.fromarray(GREYS.astype(depth) * (257 if depth is np.uint16 else 1)).save(tmp_path / "room.png")
    loaded = load_map(path)
    assert (loaded.values == -1).sum() == 0
    (note,) = loaded.notes
    assert "205 says unknown" in note
    assert "mode: trinary" in note
    shaded = GREYS.copy()
    shaded[0, 0] = 120
    alpha = np.where(GREYS == 205, 0, 255).astype(np.uint8)
    for pixels in (shaded, np.stack([GREYS, alpha], axis=-1)):
        Image.fromarray(pixels).save(tmp_path / "room.png")
        assert load_map(path).notes == ()


def test_info_says_what_a_map_is(tmp_path: Path, run: Run) -> None:
    path = written(tmp_path, "/home/anna/room.pgm")
    out = run("info", path).out
    assert "room.yaml: map, trinary, of the image /home/anna/room.pgm\n  4 × 2 cells of 0.5 m: 2.00 × 1.00 m" in out
    assert "occupied above 0.65, free below 0.196" in out
    assert "2 occupied (25.0 %), 4 free (50.0 %), 2 unknown (25.0 %)" in out
    assert "'room.pgm' beside the yaml is read in its place" in out
    facts = json.loads(run("info", path, "--json").out)
    assert (facts["occupied"], facts["free"], facts["unknown"], facts["between"]) == (2, 4, 2, 0)
    path.write_text("\ufeff" + path.read_text())  # as Windows' editor saves it
    assert "2 occupied (25.0 %)" in run("info", path).out
    path.write_text(path.read_text().replace("resolution: 0.5", "resolution: wide"))
    assert "resolution" in run("info", path).err


YAMLS = {
    "a map": ("resolution: 0.05\nimage: a.pgm\n", "describes a map, not a log"),
    "parameters": ("amcl:\n  ros__parameters:\n    alpha1: 0.2\n", "has parameters of ROS nodes, not a log"),
    "parameters in one line": ("/**: {ros__parameters: {a: 1}}\n", "has parameters of ROS nodes"),
    "a bag's metadata": ("rosbag2_bagfile_information:\n  version: 5\n", "open the bag’s folder"),
}


@pytest.mark.parametrize("name", YAMLS)
def test_a_yaml_in_place_of_a_log_is_told_what_it_is(tmp_path: Path, name: str) -> None:
    text, said = YAMLS[name]
    (tmp_path / "a.yaml").write_text(text)
    with pytest.raises(ReadError, match=said):
        open_log(tmp_path / "a.yaml")


COMMANDS = {
    "view": ("view", "{map}"),
    "costmap": ("costmap", "{map}", "--out", "{out}"),
    "path": ("path", "{map}", "--from", "7,1", "--to", "12,1", "--json"),
    "merge": ("merge", "{map}", "{map}", "--out", "{out}", "--json"),
    "match": ("match", "{map}", "{map}", "--json"),
    "edit": ("edit", "{map}", "--edits", "{edits}", "--out", "{out}", "--json"),
    "keepout mask": ("costmap", "{good}", "--keepout", "{map}", "--out", "{out}", "--json"),
}


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_that_opens_a_map_has_its_notes(tmp_path: Path, run: Run, command: str) -> None:
    edits = tmp_path / "m.edits.json"
    edits.write_text(edits_text(EditedMap(GridGeometry(0.5, 16, 32), np.zeros((16, 32), np.int8))))
    places = {
        "map": written(tmp_path / "bad", free_thresh=0.25, times=8),
        "good": written(tmp_path / "good", times=8),
        "out": tmp_path / "out",
        "edits": edits,
    }
    done = run(*(word.format(**places) for word in COMMANDS[command]))
    assert done.status == 0, done.err
    assert "Grey 205, which map_saver writes for unknown, counts as free here" in done.out


@pytest.mark.parametrize("greatest", [254, 253])
def test_the_grey_of_unknown_is_known_in_images_of_another_greatest_value(tmp_path: Path, greatest: int) -> None:
    """205 of 254 is an occupancy of 0.193, below 0.196: nav2_map_server reads unknown cells as free too."""
    path = written(tmp_path)
    (tmp_path / "room.pgm").write_bytes(f"P5\n4 2\n{greatest}\n".encode() + np.minimum(GREYS, greatest).tobytes())
    values, notes = load_map(path).values, load_map(path).notes
    assert (values == -1).sum() == 0
    (note,) = notes
    assert f"the image’s greatest value is {greatest}, not 255, and free_thresh is 0.196" in note
    remedy = note.split("; ")[1].split()[0]
    assert float(remedy) < 1.0 - 205 / greatest + 1e-3
    rows, notes = again(path, "free_thresh: 0.196", f"free_thresh: {remedy}")
    assert (np.sum(np.array(rows) == -1), notes) == (2, ())


@pytest.mark.parametrize(("yaw", "said"), [("1.5708", "turned by 90°"), ("-0.5", "turned by -28.65°"), ("0.0", None)])
def test_a_map_that_is_turned_says_what_nav2_does(tmp_path: Path, yaw: str, said: str | None) -> None:
    """navigation2#1511, navigation#166: the costs lie otherwise than the map."""
    _, notes = again(written(tmp_path), "[0, 0, 0]", f"[0.5, -1.0, {yaw}]")
    assert len(notes) == (said is not None)
    assert said is None or (
        said in notes[0] and "Nav2’s static layer and AMCL take the origin’s x and y alone" in notes[0]
    )
