"""Scans cut out of clouds and depth images, by the kernels and by the textbook."""

from __future__ import annotations

from typing import Any

from mapper.sensors.planar import textbook as planar_textbook
from mapper.sensors.planar.cloud import add_points, empty_scan
from mapper.sensors.planar.depth import cut_depth
from tests.agreement.inputs import CloudCase, DepthCase


def cloud_by_core(case: CloudCase) -> tuple[Any, ...]:
    ranges = empty_scan(case.cut)
    half = len(case.points) // 2
    for points in (case.points[:half], case.points[half:]):
        add_points(points, case.placement, case.cut, ranges)
    return (ranges,)


def cloud_by_textbook(case: CloudCase) -> tuple[Any, ...]:
    return (planar_textbook.cut_cloud(case.points, case.placement, case.cut),)


def depth_by_core(case: DepthCase) -> tuple[Any, ...]:
    return (cut_depth(case.depth, case.camera, case.cut),)


def depth_by_textbook(case: DepthCase) -> tuple[Any, ...]:
    return (planar_textbook.cut_depth(case.depth, case.camera, case.cut),)
