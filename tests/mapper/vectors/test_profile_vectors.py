"""Vectors that compare the pages' profile with the mapper: written here, read by the tests of the pages.

``python tests/mapper/vectors/test_profile_vectors.py --write`` rewrites them after a change of the models.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any, cast

import numpy as np

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.mapping.integrate import integrate_scan
from mapper.mapping.parameters import BY_NAME, CONES, MappingConfig
from mapper.mapping.sensor_model import MoravecElfes, NoReturn, beam_profile
from mapper.sensors.scan import LaserScan

VECTORS = Path(__file__).parents[3] / "static" / "src" / "grid" / "sensorModel.vectors.json"

NAMES = (
    "model", "range_max", "window", "log_odds_hit", "log_odds_miss", "p_free", "p_occ", "log_odds_prior", "no_return",
    "resolution", "sigma", "sigma_growth", "opening", "cone_profile", "prior_weight",
)  # fmt: skip

CONFIGS: tuple[dict[str, Any], ...] = (
    {},
    {"window": 0.2},
    {"window": 0.02},
    {"window": 0.5, "resolution": 0.25, "log_odds_hit": 1.4, "log_odds_miss": -0.15},
    {"model": "step_window"},
    {"model": "step_window", "window": 0.3, "p_free": 0.3, "p_occ": 0.9},
    {"model": "step_window", "window": 0.75, "resolution": 0.25, "log_odds_prior": -0.3, "p_free": 0.2, "p_occ": 0.8},
    {"range_max": 3.0},
    {"range_max": 3.0, "no_return": "free"},
    {"model": "step_window", "range_max": 3.0, "no_return": "free", "window": 0.4},
    {"range_max": 3.0, "no_return": "hit", "window": 0.1},
    {"model": "smooth_ramp"},
    {"model": "smooth_ramp", "sigma": 0.1, "sigma_growth": 0.05, "range_max": 3.0, "no_return": "free"},
    {"model": "hit_counting"},
    {"model": "hit_counting", "prior_weight": 6.0, "log_odds_prior": -0.7, "window": 0.3},
    {"model": "sonar_cone", "window": 0.2},
    {"model": "sonar_cone", "window": 0.3, "cone_profile": "gaussian", "range_max": 3.0, "no_return": "free"},
    {"model": "sonar_cone", "window": 0.0, "cone_profile": "gaussian", "opening": 1.0},
    {"model": "moravec_elfes", "window": 0.3},
    {"model": "moravec_elfes", "window": 0.2, "opening": 0.3, "range_max": 3.0, "no_return": "free"},
)

# Exact in float32, where scans keep their ranges: on borders of cells, inside them, and beyond a short max range.
READINGS = (0.03125, 0.5, 1.265625, 2.25, 2.984375, 3.0, 3.015625, 4.21875)


def cells_of(config: MappingConfig, z: float) -> list[float | None]:
    """Return what one beam along a row of cells adds to each, by integrating it into a grid; None where untouched."""
    count = round(6.0 / config.resolution)
    row = OccupancyGrid(
        GridGeometry(config.resolution, 3, count, (0.0, -config.resolution, 0.0)), config.log_odds_prior
    )
    scan = LaserScan(
        ranges=np.array([z], dtype=np.float32), angle_min=0.0, angle_increment=0.01, range_min=0.0, range_max=100.0
    )
    integrate_scan(row, scan, (0.0, config.resolution / 2.0, 0.0), config)
    on_beam, first = row.geometry.world_to_cell((0.0, config.resolution / 2.0)).tolist()  # a cone made the grid grow
    cells = np.s_[on_beam, first : first + count]
    return [
        round(float(value) - config.log_odds_prior, 5) if seen else None
        for value, seen in zip(row.log_odds[cells], row.observed[cells], strict=True)
    ]


def fans() -> list[dict[str, Any]]:
    """Return what the wide models say beside the axis of a cone, at distances and angles."""
    out = []
    for changes in CONFIGS:
        config = MappingConfig(clamp=False, **changes)
        if config.model not in CONES:
            continue
        z, half = 2.25, max(config.window, config.resolution) / 2.0
        s = [0.3, 1.5, z - half, z, z + half / 3.0, z + half, 2.8]
        theta = [share * config.opening / 2.0 for share in (-1.2, -0.99, -0.5, 0.0, 0.3, 0.7, 1.1)]
        increments = config.beam_model().increment(np.array(s)[:, None], z, np.array(theta)[None, :])
        out.append(
            {
                "parameters": {name: asdict(config)[name] for name in NAMES},
                "z": z,
                "s": s,
                "theta": theta,
                "increments": np.round(increments, 9).tolist(),
            }
        )
    return out


def vectors() -> dict[str, Any]:
    """Return every case: parameters, reading, the profile at distances s, and the increments of the cells."""
    cases = []
    for changes in CONFIGS:
        config = MappingConfig(clamp=False, **changes)
        for z in READINGS:
            half = config.window / 2.0
            s = [
                0.0,
                0.4 * z,
                z - half - 0.001,
                z - half / 2.0,
                z,
                z + half / 2.0,
                z + half + 0.001,
                2.5,
                3.0,
                3.5,
                5.0,
            ]
            profile = beam_profile(
                config.beam_model(), z, s, config.range_max, no_return=cast("NoReturn", config.no_return)
            )
            if config.model == "moravec_elfes" and z > config.range_max:
                # Their grids take no return for a cone without an arc: see update_moravec_elfes.
                profile = -MoravecElfes(0.0, config.opening).empty(s, config.range_max)
            cases.append(
                {
                    "parameters": {name: asdict(config)[name] for name in NAMES},
                    "z": z,
                    "s": s,
                    "profile": [round(float(value), 9) for value in profile],
                    # Moravec and Elfes' grids hold certainties, not sums of evidence.
                    "cells": [] if config.model == "moravec_elfes" else cells_of(config, z),
                }
            )
    rows = {
        name: {"initial": row.initial, "low": row.low, "high": row.high, "step": row.step}
        for name, row in BY_NAME.items()
        if name in NAMES
    }
    return {"table": rows, "cases": cases, "fans": fans()}


def text() -> str:
    return json.dumps(vectors(), separators=(",", ":")).replace('{"parameters"', '\n{"parameters"') + "\n"


def test_the_vectors_of_the_pages_are_those_of_the_mapper():
    stored = json.loads(VECTORS.read_text())
    fresh = json.loads(text())
    assert stored["table"] == fresh["table"], "run: python tests/mapper/vectors/test_profile_vectors.py --write"
    assert len(stored["cases"]) == len(fresh["cases"])
    for old, new in zip(stored["cases"], fresh["cases"], strict=True):
        assert {key: old[key] for key in ("parameters", "z", "s")} == {
            key: new[key] for key in ("parameters", "z", "s")
        }
        np.testing.assert_allclose(old["profile"], new["profile"], atol=1e-8)
        as_numbers = [[np.nan if value is None else value for value in one["cells"]] for one in (old, new)]
        np.testing.assert_allclose(as_numbers[0], as_numbers[1], atol=1e-5)
    assert len(stored["fans"]) == len(fresh["fans"])
    for old, new in zip(stored["fans"], fresh["fans"], strict=True):
        assert {**old, "increments": None} == {**new, "increments": None}
        np.testing.assert_allclose(old["increments"], new["increments"], atol=1e-8)


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(text())
