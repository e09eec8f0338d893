"""Drawings of a map in 3D: what is made again when another colouring is chosen, and the colours by normal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.volume import OccupancyVolume, VolumeConfig
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.volume import drawings
from server.parts.volume.drawings import VolumeDrawings
from server.parts.volume.look import Look, normal_colors
from server.parts.volume.point_values import PointValues
from server.sessions.drawings import Points, Voxels


class Shown:
    """A room of a floor and a wall, whose chunks are made again one by one."""

    def __init__(self, scans: int = 1) -> None:
        a, b = np.meshgrid(np.linspace(0.01, 9.9, 200), np.linspace(0.01, 9.9, 200))
        floor = np.column_stack([a.ravel(), b.ravel(), np.full(a.size, 0.05)])
        wall = np.column_stack([np.full(a.size, 9.95), a.ravel(), b.ravel()])
        self.points = points = np.concatenate([floor, wall]).astype(np.float32)
        self.volume = OccupancyVolume(VolumeConfig(resolution=0.1))
        origin = np.array([5.0, 5.0, 5.0])
        self.volume.insert_scan(points, origin)
        starts = np.linspace(0, len(points), scans + 1).astype(np.int64)
        origins = np.tile(origin, (scans, 1))
        sequence = ScanSequence("pcd", points, starts, origins, np.zeros(scans, np.int64), np.zeros(3))
        low, high = points.min(axis=0).astype(float), points.max(axis=0).astype(float)
        self.drawn = VolumeDrawings(sequence, low, high, PointValues(sequence))
        self.look = Look(band=1.0)
        self.drawn.note_change(self.volume, None)

    def work(self, pieces: int | None = None, index: int = 1) -> Voxels:
        while self.drawn.pending and pieces != 0:
            self.drawn.work(self.volume, index, self.look, has_free=True, is_over=lambda: True)
            pieces = None if pieces is None else pieces - 1
        return next(one for one in self.drawn.current(self.volume, self.look) if isinstance(one, Voxels))

    def choose(self, **values: object) -> None:
        old, self.look = self.look, replace(self.look, **values)  # type: ignore[arg-type]
        self.drawn.note_look(self.volume, old, self.look)


def test_no_chunk_is_shown_in_the_colours_of_another_colouring() -> None:
    shown = Shown()
    heights = shown.work().chunks
    assert len(heights) > 10
    for colouring in ("normal", "probability", "height"):
        shown.choose(colour=colouring)
        assert shown.work(0).chunks == {}
        some = shown.work(3).chunks
        assert len(some) <= 3 < len(heights)
        lowest = min(key[2] for key in heights)
        assert all(key[2] == lowest for key in some)
        assert shown.work().chunks.keys() == heights.keys()
    # Sides have the rectangles of heights: nothing is made again.
    before = shown.work().chunks
    shown.choose(colour="side")
    assert shown.drawn.pending == 0
    assert shown.work().chunks is before


def test_floor_and_wall_have_the_colours_of_their_normals() -> None:
    shown = Shown()
    shown.choose(colour="normal")
    voxels = shown.work()
    assert not voxels.by_side
    up, across = normal_colors(np.array([(0, 0, 127), (-127, 0, 0)], dtype=np.int8)).astype(int)
    area = {"floor": [0, 0], "wall": [0, 0]}  # right, all
    for quads in voxels.chunks.values():
        for side, *_, wide, high, colour in quads.astype(int).tolist():
            name = {5: "floor", 0: "wall"}.get(side)
            if name is None:
                continue
            wanted = up if name == "floor" else across
            area[name][0] += wide * high * int(np.abs(voxels.palette[colour - 1].astype(int) - wanted).max() < 25)
            area[name][1] += wide * high
    for right, every in area.values():
        assert right > 0.9 * every > 1000


def test_a_cut_leaves_the_points_as_they_are_and_moves_their_clip_box() -> None:
    shown = Shown()

    def points() -> Points:
        shown.work()
        return next(one for one in shown.drawn.current(shown.volume, shown.look) if isinstance(one, Points))

    shown.choose(show="points")
    before = points()
    assert len(before.points) == 2 * 200 * 200
    shown.choose(cut_low=-1.0, cut_high=2.5)
    after = points()
    assert after.points is before.points
    assert after.colors is before.colors
    assert after.clip is not None
    assert (after.clip[0][2], after.clip[1][2]) == (-1.0, 2.5)


def test_a_large_cloud_is_drawn_in_pieces_that_begin_with_samples_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawings, "IN_A_DRAWING", 30_000)
    monkeypatch.setattr(drawings, "IN_ORDER", 10_000)
    shown = Shown()  # a floor of 40,000 points, then a wall of as many
    shown.choose(show="points")
    shown.work()
    pieces = [one for one in shown.drawn.current(shown.volume, shown.look) if isinstance(one, Points)]
    assert [len(piece.points) for piece in pieces] == [30_000, 30_000, 20_000]
    assert len({piece.name for piece in pieces}) == 3
    assert {(piece.label, piece.clip) for piece in pieces} == {("Points", (shown.look.low, shown.look.high))}
    every = np.concatenate([piece.points for piece in pieces])
    assert len(np.unique(every, axis=0)) == len(np.unique(shown.points, axis=0))
    colors = np.concatenate([np.asarray(piece.colors) for piece in pieces])
    assert len(np.unique(colors[every[:, 2] < 0.1], axis=0)) == 1, "each point has kept its colour"
    for piece in pieces:
        on_wall = piece.points[:2000, 0] > 9.94
        assert 0.45 < on_wall.mean() < 0.55


def test_fewer_points_are_drawn_before_the_last_scan(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawings, "MOST_WHILE_CHANGING", 100)
    shown = Shown(scans=2)
    shown.choose(show="points")

    def drawn(index: int) -> int:
        shown.drawn.note_change(shown.volume, None)
        shown.work(index=index)
        return sum(len(one.points) for one in shown.drawn.current(shown.volume, shown.look) if isinstance(one, Points))

    assert drawn(1) == 100
    assert drawn(2) == 80_000
