"""Airborne point clouds with known labels: towns, slopes, terraces, quarries, forests, bridges, railway yards.

A scene is a height field of bare ground and objects on it. A laser looks straight down along zigzag lines, so that the
distance of points varies; what it meets first is an object (a roof, a deck, a car, a trunk or a crown) or the ground.
Crowns let a share of the pulses through. Nothing here is taken from a real cloud.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Field = Callable[[Floats, Floats], Floats]  #: heights, metres, at places x, y in metres


@dataclass(frozen=True)
class _Top:
    """Heights of an object, NaN where it is not; the share of pulses that meet it; where it begins and ends in x."""

    height: Field
    share: float
    first: float
    last: float


@dataclass
class Scene:
    """Bare ground and what stands on it, on a square of ``side`` metres; objects that were added later lie above."""

    side: float
    ground: Field
    rng: np.random.Generator
    tops: list[_Top] = field(default_factory=list)
    gaps: list[Callable[[Floats, Floats], Bools]] = field(default_factory=list)

    def add(self, top: Field, share: float = 1.0, x: float = 0.0, reach: float = math.inf) -> None:
        """Add an object, at most ``reach`` from ``x``, whose top is met by a ``share`` of the pulses that pass it."""
        self.tops.append(_Top(top, share, x - reach, x + reach))

    def box(
        self, x: float, y: float, length: float, width: float, turn: float, height: float, roof: float = 0.0
    ) -> None:
        """Add a house: its eaves lie ``height`` above the mean of the ground below it, its ridge ``roof`` higher."""
        base = float(self.ground(np.array([x]), np.array([y]))[0])

        def top(px: Floats, py: Floats) -> Floats:
            along, across = _turned(px - x, py - y, turn)
            inside = (np.abs(along) <= length / 2) & (np.abs(across) <= width / 2)
            return np.where(inside, base + height + roof * (1.0 - 2.0 * np.abs(across) / width), np.nan)

        self.add(top, 1.0, x, 0.5 * math.hypot(length, width))

    def tree(self, x: float, y: float, radius: float, height: float, share: float) -> None:
        """Add a tree with a round crown."""
        base = float(self.ground(np.array([x]), np.array([y]))[0])

        def top(px: Floats, py: Floats) -> Floats:
            away = np.hypot(px - x, py - y) / radius
            crown = base + height * (0.55 + 0.45 * np.sqrt(np.maximum(1.0 - away**2, 0.0)))
            return np.where(away <= 1.0, crown, np.nan)

        self.add(top, share, x, radius)

    def trees(
        self, n: int, height: tuple[float, float], share: float, where: Callable[[float, float], bool] | None = None
    ) -> None:
        """Add ``n`` trees at random places."""
        for _ in range(n):
            x, y = self.rng.uniform(0.0, self.side, 2)
            tall = self.rng.uniform(*height)
            if where is None or where(x, y):
                self.tree(x, y, self.rng.uniform(0.15, 0.3) * tall + 0.8, tall, share)

    def undergrowth(self, cover: float, height: tuple[float, float], patch: float) -> None:
        """Add low plants over a share ``cover`` of the ground, in patches of about ``patch`` metres."""
        mask, tall = noise(self.rng, self.side, patch), noise(self.rng, self.side, patch / 3.0)
        edge = _quantile(mask, self.side, 1.0 - cover)

        def top(px: Floats, py: Floats) -> Floats:
            part = 0.5 + 0.5 * np.tanh(tall(px, py))
            z = self.ground(px, py) + height[0] + (height[1] - height[0]) * part
            return np.where(mask(px, py) >= edge, z, np.nan)

        self.add(top, 0.6)

    def points(
        self, density: float, noise_m: float = 0.06, low: float = 2e-4, high: float = 2e-4
    ) -> tuple[Floats, Bools]:
        """Return points (n, 3) and which of them are ground; ``low`` and ``high`` are shares of outliers."""
        rng, side = self.rng, self.side
        between = math.sqrt(1.6 / density)
        lines = int(side / between)
        along = np.sort(rng.uniform(0.0, side, (lines, max(int(side * between * density), 2))), axis=1)
        even = np.broadcast_to(np.linspace(0.0, side, along.shape[1]), along.shape)
        y = 0.75 * even + 0.25 * along
        turn = 0.5 * between * np.abs((y / 40.0 % 2.0) - 1.0)
        x = (np.arange(lines)[:, None] + 0.5) * between + turn + rng.normal(0.0, 0.08 * between, along.shape)
        px, py = np.clip(x, 0.0, side - 1e-6).ravel(), np.clip(y, 0.0, side - 1e-6).ravel()
        keep = np.ones(len(px), dtype=np.bool_)
        for gap in self.gaps:
            keep &= ~gap(px, py)
        px, py = px[keep], py[keep]
        z = self.ground(px, py)
        bare, is_ground = z.copy(), np.ones(len(px), dtype=np.bool_)
        order = np.argsort(px, kind="stable")
        sorted_x = px[order]
        for top in self.tops:
            near = order[np.searchsorted(sorted_x, top.first) : np.searchsorted(sorted_x, top.last, side="right")]
            there = top.height(px[near], py[near])
            met = ~np.isnan(there) & (there > z[near])
            if top.share < 1.0:
                met &= rng.random(len(near)) < top.share
                deep = rng.beta(4.0, 1.3, len(near))  # within the crown, mostly near its top
                there = bare[near] + deep * (there - bare[near])
            z[near[met]], is_ground[near[met]] = there[met], False
        z += rng.normal(0.0, noise_m, len(z))
        for share_of_points, lowest, highest in ((low, -15.0, -3.0), (high, 10.0, 60.0)):
            some = rng.random(len(z)) < share_of_points
            z[some] += rng.uniform(lowest, highest, int(some.sum()))
            is_ground &= ~some
        return np.column_stack([px, py, z]), is_ground


def noise(rng: np.random.Generator, side: float, wave: float, octaves: int = 3, fall: float = 0.5) -> Field:
    """Return a smooth random field: sums of waves of length ``wave``, ``wave`` / 2 …, each ``fall`` times as high."""
    parts = []
    for octave in range(octaves):
        for _ in range(8):
            angle, length = rng.uniform(0.0, 2.0 * math.pi), wave / 2**octave * rng.uniform(0.8, 1.4)
            k = 2.0 * math.pi / length
            parts.append((k * math.cos(angle), k * math.sin(angle), rng.uniform(0.0, 7.0), fall**octave / 2.0))

    def height(x: Floats, y: Floats) -> Floats:
        total = np.zeros(np.shape(x))
        for a, b, phase, amplitude in parts:
            total += amplitude * np.sin(a * x + b * y + phase)
        return total

    return height


def _turned(x: Floats, y: Floats, turn: float) -> tuple[Floats, Floats]:
    return math.cos(turn) * x + math.sin(turn) * y, math.cos(turn) * y - math.sin(turn) * x


def _quantile(height: Field, side: float, share: float) -> float:
    x, y = np.meshgrid(np.linspace(0.0, side, 100), np.linspace(0.0, side, 100))
    return float(np.quantile(height(x, y), share))


def _houses(scene: Scene, every: float, share: float, sizes: tuple[float, float], heights: tuple[float, float]) -> None:
    rng = scene.rng
    turn = rng.uniform(0.0, 0.5)
    for row in range(int(scene.side / every)):
        for col in range(int(scene.side / every)):
            if rng.random() < share:
                x, y = ((np.array([row, col]) + 0.5) * every + rng.uniform(-0.15, 0.15, 2) * every).tolist()
                length, width = rng.uniform(*sizes), rng.uniform(sizes[0], 0.5 * sum(sizes))
                scene.box(
                    x,
                    y,
                    length,
                    width,
                    turn + rng.choice([0.0, math.pi / 2]),
                    rng.uniform(*heights),
                    rng.uniform(0.0, 3.0),
                )


def _cars(scene: Scene, n: int) -> None:
    for x, y in scene.rng.uniform(0.0, scene.side, (n, 2)).tolist():
        scene.box(x, y, 4.3, 1.8, scene.rng.uniform(0.0, 3.0), scene.rng.uniform(1.2, 1.9))


def _hills(rng: np.random.Generator, side: float, degrees: float, wave: float) -> Field:
    """Return hills of which the steepest twentieth has about ``degrees``."""
    shape = noise(rng, side, wave, 2, 0.35)
    x, y = np.meshgrid(np.linspace(0.0, side, 200), np.linspace(0.0, side, 200))
    steep = np.hypot(*np.gradient(shape(x, y), side / 199))
    factor = math.tan(math.radians(degrees)) / float(np.quantile(steep, 0.95))
    rough = noise(rng, side, 9.0)
    return lambda px, py: factor * shape(px, py) + 0.12 * rough(px, py)


def _town(rng: np.random.Generator) -> Scene:
    scene = Scene(200.0, _hills(rng, 200.0, 4.0, 150.0), rng)
    _houses(scene, 28.0, 0.8, (9.0, 22.0), (4.0, 14.0))
    _cars(scene, 120)
    scene.trees(160, (4.0, 14.0), 0.75)
    return scene


def _hillside_town(rng: np.random.Generator) -> Scene:
    """Houses cut into a slope of 20 to 30°: the eaves at their upper side are near the ground."""
    hills = _hills(rng, 200.0, 14.0, 120.0)
    scene = Scene(200.0, lambda x, y: hills(x, y) + 0.4 * x, rng)
    _houses(scene, 26.0, 0.7, (8.0, 18.0), (3.5, 8.0))
    scene.trees(420, (3.0, 15.0), 0.8)
    scene.undergrowth(0.12, (0.4, 2.5), 20.0)
    scene.gaps.append(lambda x, y: (np.abs(x - 60.0) < 7.0) & (np.abs(y - 120.0) < 25.0))
    return scene


def _large_roofs(rng: np.random.Generator) -> Scene:
    """Blocks with courts, halls of 60 m, and gaps in the data beside them."""
    scene = Scene(220.0, _hills(rng, 220.0, 5.0, 150.0), rng)
    for x, y in ((55.0, 55.0), (165.0, 60.0), (60.0, 165.0)):
        tall = rng.uniform(8.0, 20.0)
        for turn, dx, dy in ((0.0, 0.0, -22.0), (0.0, 0.0, 22.0), (1.5708, -22.0, 0.0), (1.5708, 22.0, 0.0)):
            scene.box(x + dx, y + dy, 58.0, 14.0, turn, tall, 2.0)
    scene.box(160.0, 160.0, 62.0, 34.0, 0.2, 9.0)
    scene.box(160.0, 160.0, 20.0, 15.0, 0.2, 16.0)
    _cars(scene, 80)
    scene.trees(90, (4.0, 12.0), 0.75)
    scene.gaps.append(lambda x, y: (x > 95.0) & (x < 112.0) & (y > 20.0) & (y < 90.0))
    return scene


def _railway(rng: np.random.Generator) -> Scene:
    """A yard with trains of 3 m × 120 m, a station hall, a clump of low outliers and gaps."""
    scene = Scene(220.0, _hills(rng, 220.0, 2.0, 160.0), rng)
    for i in range(9):
        if rng.random() < 0.75:
            scene.box(30.0 + 10.0 * i, rng.uniform(70.0, 150.0), rng.uniform(60.0, 130.0), 3.0, math.pi / 2, 3.9)
    scene.box(150.0, 110.0, 150.0, 25.0, math.pi / 2, 10.0, 3.0)
    _houses(scene, 55.0, 0.3, (10.0, 20.0), (5.0, 15.0))
    scene.trees(60, (4.0, 12.0), 0.75)
    scene.gaps.append(lambda x, y: (x > 185.0) & (y < 75.0))
    scene.gaps.append(lambda x, y: np.hypot(x - 20.0, y - 190.0) < 18.0)
    return scene


def _river_bridge(rng: np.random.Generator) -> Scene:
    """A road on a dam over a river: its bridge is an object, the dam is ground; water gives few points."""
    hills = _hills(rng, 240.0, 5.0, 150.0)

    def ground(x: Floats, y: Floats) -> Floats:
        river = 7.0 / (1.0 + np.exp((np.abs(x - 120.0) - 22.0) / 1.6))
        dam = np.clip(5.5 - np.maximum(np.abs(y - 120.0) - 7.0, 0.0) / 1.7, 0.0, 5.5) * (np.abs(x - 120.0) > 30.0)
        return hills(x, y) * 0.4 - river + dam

    scene = Scene(240.0, ground, rng)
    deck = float(ground(np.array([80.0]), np.array([120.0]))[0]), float(ground(np.array([160.0]), np.array([120.0]))[0])

    def bridge(x: Floats, y: Floats) -> Floats:
        share = (x - 80.0) / 80.0
        return np.where(
            (np.abs(x - 120.0) <= 30.5) & (np.abs(y - 120.0) <= 7.0), (1 - share) * deck[0] + share * deck[1], np.nan
        )

    scene.add(bridge)
    scene.box(120.0, 40.0, 64.0, 3.0, 0.0, 9.0)
    scene.trees(150, (3.0, 14.0), 0.75, lambda x, _: abs(x - 120.0) > 25.0)
    _houses(scene, 60.0, 0.4, (9.0, 16.0), (5.0, 9.0))
    scene.gaps.append(
        lambda x, y: (np.abs(x - 120.0) < 14.0) & (np.sin(0.9 * y + x) > -0.7) & (np.abs(y - 120.0) > 7.0)
    )
    return scene


def _underpass(rng: np.random.Generator) -> Scene:
    """Roads on dams and in cuttings with steep banks, and a bridge where two of them cross."""
    hills = _hills(rng, 300.0, 6.0, 200.0)

    def ground(x: Floats, y: Floats) -> Floats:
        away = np.abs(0.8 * (x - 150.0) + 0.6 * (y - 150.0))
        cutting = -np.clip(6.0 - np.maximum(away - 6.0, 0.0) / 1.5, 0.0, 6.0)
        other = np.abs(0.6 * (x - 150.0) - 0.8 * (y - 150.0))
        dam = np.clip(5.0 - np.maximum(other - 5.0, 0.0) / 1.5, 0.0, 5.0)
        return hills(x, y) * 0.5 + np.where(away < 16.0, cutting, dam)

    scene = Scene(300.0, ground, rng)

    def bridge(x: Floats, y: Floats) -> Floats:
        away = np.abs(0.8 * (x - 150.0) + 0.6 * (y - 150.0))
        other = np.abs(0.6 * (x - 150.0) - 0.8 * (y - 150.0))
        return np.where((away < 16.5) & (other < 5.0), hills(x, y) * 0.5 + 5.0, np.nan)

    scene.add(bridge)
    scene.trees(150, (3.0, 13.0), 0.7)
    _houses(scene, 70.0, 0.3, (9.0, 15.0), (5.0, 9.0))
    return scene


def _moderate_forest(rng: np.random.Generator) -> Scene:
    scene = Scene(320.0, _hills(rng, 320.0, 18.0, 160.0), rng)
    border = noise(rng, 320.0, 120.0)
    scene.trees(2200, (6.0, 20.0), 0.6, lambda x, y: float(border(np.array([x]), np.array([y]))[0]) > 0.3)
    _houses(scene, 80.0, 0.3, (8.0, 14.0), (5.0, 8.0))
    return scene


def _steep_terraces(rng: np.random.Generator) -> Scene:
    """A bank of 30 to 40° with terraces of 2 to 5 m, some walls vertical, and low plants beside them."""
    hills = _hills(rng, 320.0, 16.0, 150.0)

    def ground(x: Floats, y: Floats) -> Floats:
        bend = x + 12.0 * np.sin(y / 35.0)
        bank = 38.0 / (1.0 + np.exp(-(bend - 110.0) / 11.0))
        step = 4.0
        level = bank / step
        sharp = np.floor(level) + np.clip((level - np.floor(level) - 0.75) / 0.25, 0.0, 1.0)
        on_terraces = 1.0 / (1.0 + np.exp(-(y - 150.0) / 2.0))
        upper = 5.0 * (np.floor((bend - 170.0) / 28.0).clip(0.0, 4.0))
        return hills(x, y) + bank * (1.0 - on_terraces) + step * sharp * on_terraces + upper

    scene = Scene(320.0, ground, rng)
    scene.undergrowth(0.08, (0.5, 2.0), 18.0)
    scene.trees(330, (2.5, 12.0), 0.7)
    return scene


def _quarry(rng: np.random.Generator) -> Scene:
    """Benches of 5 to 14 m with faces of 60 to 90°, heaps, and only 4 % objects."""
    hills, bend = _hills(rng, 320.0, 14.0, 170.0), noise(rng, 320.0, 110.0)

    def ground(x: Floats, y: Floats) -> Floats:
        away = np.hypot(x - 150.0, y - 170.0) + 14.0 * bend(x, y)
        pit = np.zeros(np.shape(x))
        for radius, deep, run in ((110.0, 9.0, 1.0), (82.0, 13.0, 3.0), (60.0, 6.0, 0.3), (36.0, 8.0, 4.0)):
            pit -= deep * np.clip((radius - away) / run, 0.0, 1.0)
        heaps = np.zeros(np.shape(x))
        for cx, cy, tall in ((150.0, 175.0, 7.0), (262.0, 60.0, 9.0), (280.0, 95.0, 6.0), (40.0, 290.0, 8.0)):
            heaps = np.maximum(heaps, tall - 0.7 * np.hypot(x - cx, y - cy))
        return hills(x, y) + pit + heaps

    scene = Scene(320.0, ground, rng)
    scene.trees(150, (2.5, 10.0), 0.7)
    scene.undergrowth(0.015, (0.5, 1.6), 12.0)
    scene.box(150.0, 215.0, 14.0, 9.0, 0.4, 6.0)
    return scene


def _village(rng: np.random.Generator) -> Scene:
    scene = Scene(260.0, _hills(rng, 260.0, 8.0, 160.0), rng)
    _houses(scene, 24.0, 0.75, (8.0, 14.0), (3.0, 7.0))
    scene.trees(1100, (3.0, 12.0), 0.65)
    return scene


def _banks(rng: np.random.Generator) -> Scene:
    """Fields with steep banks and ditches, few objects and a large gap."""
    hills = _hills(rng, 340.0, 10.0, 200.0)

    def ground(x: Floats, y: Floats) -> Floats:
        road = np.clip(6.0 - np.maximum(np.abs(x - 120.0 + 0.2 * y) - 8.0, 0.0) / 1.4, 0.0, 6.0)
        ditch = -2.5 * np.exp(-(((x - 240.0 + 0.1 * y) / 2.5) ** 2))
        edge = 4.0 * (y > 230.0 + 10.0 * np.sin(x / 30.0))
        return hills(x, y) + road + ditch + edge

    scene = Scene(340.0, ground, rng)
    scene.trees(110, (3.0, 14.0), 0.7)
    _houses(scene, 110.0, 0.3, (10.0, 18.0), (5.0, 9.0))
    scene.gaps.append(lambda x, y: (np.abs(x - 200.0) < 35.0) & (np.abs(y - 90.0) < 55.0))
    return scene


def _steep_forest(rng: np.random.Generator) -> Scene:
    """A dense forest with undergrowth on slopes of up to 45°."""
    hills = _hills(rng, 160.0, 20.0, 90.0)
    scene = Scene(160.0, lambda x, y: hills(x, y) + 0.6 * y, rng)
    scene.trees(900, (8.0, 25.0), 0.75)
    scene.undergrowth(0.15, (0.4, 2.0), 14.0)
    return scene


def _ridges(rng: np.random.Generator) -> Scene:
    """Sharp ridges and gullies with sides of 40 to 45°."""
    bend, rough = noise(rng, 260.0, 120.0), noise(rng, 260.0, 10.0)

    def ground(x: Floats, y: Floats) -> Floats:
        across = x + 9.0 * bend(x, y)
        return 0.9 * np.abs((across / 44.0 % 2.0) - 1.0) * 44.0 + 0.15 * rough(x, y) + 0.15 * y

    scene = Scene(260.0, ground, rng)
    scene.trees(260, (3.0, 14.0), 0.7)
    return scene


def _walls_and_gardens(rng: np.random.Generator) -> Scene:
    """Gardens on terraces of 1.5 to 3 m that follow a slope, with walls, hedges and sheds."""
    hills = _hills(rng, 160.0, 6.0, 120.0)

    def ground(x: Floats, y: Floats) -> Floats:
        level = (0.3 * x + 2.0 * np.sin(y / 25.0)) / 2.4
        return hills(x, y) + 2.4 * (np.floor(level) + np.clip((level - np.floor(level) - 0.95) / 0.05, 0.0, 1.0))

    scene = Scene(160.0, ground, rng)
    _houses(scene, 30.0, 0.6, (8.0, 14.0), (3.5, 7.0))
    for x, y in scene.rng.uniform(0.0, 160.0, (30, 2)).tolist():
        scene.box(x, y, scene.rng.uniform(8.0, 20.0), 1.2, math.pi / 2, 1.8)
    scene.trees(150, (2.5, 9.0), 0.75)
    return scene


#: name: the scene, points per m²
SCENES: dict[str, tuple[Callable[[np.random.Generator], Scene], float]] = {
    "town": (_town, 1.0),
    "town, dense": (_town, 8.0),
    "town on a hillside": (_hillside_town, 1.0),
    "large roofs, gaps": (_large_roofs, 1.0),
    "railway yard": (_railway, 1.0),
    "river, bridges": (_river_bridge, 1.0),
    "dams, cutting, bridge": (_underpass, 0.2),
    "forest on moderate slopes": (_moderate_forest, 0.2),
    "bank with terraces": (_steep_terraces, 0.2),
    "bank with terraces, dense": (_steep_terraces, 4.0),
    "quarry": (_quarry, 0.3),
    "quarry, dense": (_quarry, 3.0),
    "village, sparse": (_village, 0.2),
    "banks, large gap": (_banks, 0.3),
    "forest on 45°": (_steep_forest, 1.0),
    "forest on 45°, dense": (_steep_forest, 20.0),
    "ridges": (_ridges, 0.5),
    "gardens on terraces": (_walls_and_gardens, 2.0),
}


def labelled_cloud(name: str, seed: int = 0) -> tuple[Floats, Bools]:
    """Return the points (n, 3) of a scene, metres with z up, and which of them are ground."""
    make, density = SCENES[name]
    return make(np.random.default_rng(seed)).points(density)
