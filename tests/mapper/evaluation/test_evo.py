"""Trajectory errors against evo 1.38.1 (PyPI), an independent program, on the same two trajectories."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest

from mapper.evaluation import ComparisonOptions, ErrorSeries, compare_trajectories
from mapper.io.trajectories import read_tum
from tests.mapper.evaluation.trajectories import estimate, reference

#: alignment → rmse, mean, median, std, min, max, sse of evo's APE: translation part (m) and rotation angle (rad)
ABSOLUTE = {
    "none": (
        (3.776899922, 3.426318895, 3.524333947, 1.589122981, 0.040164265, 5.973153823, 2139.745952598),
        (0.600313548, 0.599936659, 0.600212702, 0.021268784, 0.570007925, 0.629995291, 54.056453333),
    ),
    "origin": (
        (0.183737101, 0.170862044, 0.177830438, 0.067568368, 0.0, 0.304628077, 5.063898352),
        (0.025710916, 0.02137664, 0.01560452, 0.014286024, 0.0, 0.044374841, 0.09915768),
    ),
    "rigid": (
        (0.161760828, 0.151373033, 0.159701985, 0.057033061, 0.023096319, 0.246102343, 3.924984799),
        (0.021268818, 0.019194751, 0.021122283, 0.009161013, 0.000104177, 0.030020438, 0.067854395),
    ),
    "scaled": (
        (0.045255891, 0.043280975, 0.045400843, 0.013223195, 0.006269101, 0.064285602, 0.307214349),
        (0.021268818, 0.019194751, 0.021122283, 0.009161013, 0.000104177, 0.030020438, 0.067854395),
    ),
}
#: delta, unit, all pairs, pairs from the reference → number of pairs, and the figures of evo's RPE without alignment
RELATIVE = {
    (1.0, "frames", False, False): (
        149,
        (0.072994139, 0.069236468, 0.069722047, 0.023118299, 0.003208065, 0.12595524, 0.793893497),
        (0.042164422, 0.038032626, 0.04205377, 0.018203238, 0.000265122, 0.059496528, 0.264897936),
    ),
    (10.0, "frames", True, False): (
        140,
        (0.202351282, 0.191772722, 0.185605127, 0.06456984, 0.063814177, 0.344111921, 5.732445765),
        (0.040919781, 0.036912787, 0.041201449, 0.017659973, 0.001021984, 0.057683649, 0.23441999),
    ),
    (7.0, "frames", False, False): (
        21,
        (0.157020726, 0.146989898, 0.147488968, 0.055222081, 0.029177588, 0.251188863, 0.517765675),
        (0.026174358, 0.023402363, 0.024980013, 0.011722902, 0.002656374, 0.037076814, 0.014387038),
    ),
    (1.0, "m", False, False): (
        63,
        (0.092867405, 0.083215803, 0.086059189, 0.041224811, 0.015825461, 0.171519435, 0.54333436),
        (0.023413319, 0.01747177, 0.01298926, 0.015585916, 0.000247517, 0.055204028, 0.034535561),
    ),
    (1.0, "m", True, False): (
        42,
        (0.07146995, 0.065728247, 0.062295773, 0.028066907, 0.018218127, 0.123133995, 0.214534056),
        (0.02587814, 0.019867186, 0.013982141, 0.01658231, 0.00089525, 0.055545744, 0.02812648),
    ),
    (1.0, "m", True, True): (
        50,
        (0.084693681, 0.076841344, 0.074245675, 0.035614989, 0.018218127, 0.148526403, 0.358650981),
        (0.029172909, 0.022948094, 0.014520361, 0.018012319, 0.000247517, 0.055545744, 0.042552932),
    ),
    (2.5, "m", False, True): (
        28,
        (0.11833944, 0.113771457, 0.113312725, 0.032561919, 0.06102484, 0.189763863, 0.392118245),
        (0.02813216, 0.025846053, 0.02767294, 0.011108555, 0.010009842, 0.043222043, 0.022159716),
    ),
}
#: evo_ape -a, evo_ape -a -r angle_deg and evo_rpe -d 1 -u m on two trajectories of Intel, of which the reference has
#: stamps that repeat and run backwards: rmse, mean, median, std, min, max (evo prints six decimals)
INTEL_ABSOLUTE_M = (0.173266, 0.153092, 0.146772, 0.081142, 0.000960, 0.590807)
INTEL_ABSOLUTE_DEG = (3.995358, 2.588040, 1.730705, 3.043836, 0.000131, 47.365388)
INTEL_RELATIVE_M = (0.133058, 0.106867, 0.087485, 0.079270, 0.003126, 0.493810)
DIGITS = 2e-9  #: evo's figures were written down with nine decimals; its angles come from arc cosines of matrices


def assert_statistics(found: Sequence[ErrorSeries], expected: Sequence[object]) -> None:
    """Compare translation and rotation with evo's figures."""
    for series, figures in zip(found, expected, strict=True):
        assert astuple(series.statistics) == pytest.approx(figures, rel=1e-9, abs=DIGITS)


@pytest.mark.parametrize("how", ABSOLUTE)
def test_absolute_errors_are_evos(how: str) -> None:
    found = compare_trajectories(reference(), estimate(), ComparisonOptions(align=how))
    assert len(found.estimate) == 150
    assert_statistics((found.absolute_translation, found.absolute_rotation), ABSOLUTE[how])


def test_the_alignment_is_evos() -> None:
    found = compare_trajectories(reference(), estimate(), ComparisonOptions(align="scaled")).alignment
    assert found.scale == pytest.approx(0.9708243494034899, abs=1e-12)
    assert (found.x, found.y) == pytest.approx((-1.05440718, 1.89715418), abs=1e-8)


@pytest.mark.parametrize("case", RELATIVE)
def test_relative_errors_are_evos(case: tuple[float, str, bool, bool]) -> None:
    delta, unit, all_pairs, from_reference = case
    options = ComparisonOptions(
        align="none", delta=delta, delta_unit=unit, all_pairs=all_pairs, pairs_from_reference=from_reference
    )
    found = compare_trajectories(reference(), estimate(), options)
    count, *expected = RELATIVE[case]
    assert len(found.relative_translation.errors) == count
    assert_statistics((found.relative_translation, found.relative_rotation), expected)


def test_errors_of_real_trajectories_are_evos(data_file: Callable[[str], Path]) -> None:
    found = compare_trajectories(
        read_tum(data_file("carmen/intel.ref.tum")), read_tum(data_file("carmen/intel.flirt_graph.tum"))
    )
    assert astuple(found.absolute_translation.statistics)[:6] == pytest.approx(INTEL_ABSOLUTE_M, abs=2e-6)
    degrees = np.degrees(astuple(found.absolute_rotation.statistics)[:6])
    assert degrees == pytest.approx(INTEL_ABSOLUTE_DEG, abs=2e-6)
    assert astuple(found.relative_translation.statistics)[:6] == pytest.approx(INTEL_RELATIVE_M, abs=2e-6)
