"""The one table of kernels: each with its textbook twin and a generator of inputs for both.

A row's ``kernel`` and ``twin`` take one case and return the arrays and numbers that must be equal. What a twin uses of
the product beside poses, grids, sensors and parameters is in :data:`SHARED`; the other rows compare independent code.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from hypothesis import strategies as st

from tests.agreement.asking import (
    provenance_by_kernel,
    provenance_by_textbook,
    provenance_of_counts_by_textbook,
    provenance_of_scans_by_textbook,
    provenance_of_sweeps_by_kernel,
    provenance_of_sweeps_by_textbook,
)
from tests.agreement.beams_of_lidar import (
    beams_cast_by_kernel,
    beams_cast_by_textbook,
    lidars,
    readings_by_kernel,
    readings_by_textbook,
)
from tests.agreement.chunks import parts_by_kernel, parts_by_textbook
from tests.agreement.costmap import (
    costmap_cases,
    denoised_by_layer,
    denoised_by_textbook,
    inflated_by_kernel,
    inflated_by_textbook,
    interpreted_by_table,
    interpreted_by_textbook,
    laid_by_kernel,
    laid_by_textbook,
    observed_by_kernel,
    observed_by_textbook,
    voxel_cases,
    voxels_by_kernel,
    voxels_by_textbook,
)
from tests.agreement.decimals import readings, text_by_encoder, text_by_kernel
from tests.agreement.driving import driven_by_kernel, driven_by_textbook, drives
from tests.agreement.grids import (
    merged_by_core,
    merged_by_textbook,
    picture_by_kernel,
    picture_by_textbook,
    picture_of_cells_by_kernel,
    sorted_by_kernel,
    sorted_by_textbook,
    states_by_core,
    states_by_textbook,
)
from tests.agreement.inputs import (
    STEPS,
    clouds,
    depths,
    lines,
    listed_cells,
    mapping_cases,
    pictures,
    rays,
    states,
    sweeping_cases,
    two_maps,
)
from tests.agreement.lines import (
    line_by_kernel,
    line_by_textbook,
    ray_by_kernel,
    ray_by_textbook,
)
from tests.agreement.localization import (
    beams_by_kernel,
    beams_by_textbook,
    clusters_by_kernel,
    clusters_by_textbook,
    drawn_by_kernel,
    drawn_by_textbook,
    localization_cases,
    moved_by_kernel,
    moved_by_textbook,
    numbers_by_filter,
    numbers_by_textbook,
    resampled_by_kernel,
    resampled_by_textbook,
    scored_by_kernel,
    scored_by_textbook,
    unexplained_by_kernel,
    unexplained_by_textbook,
)
from tests.agreement.mapping import (
    bounds_by_kernel,
    bounds_by_textbook,
    bounds_of_sweeps_by_textbook,
    map_by_kernel,
    map_by_textbook,
    map_of_single_scans,
    map_of_single_scans_by_textbook,
    statistics_by_kernel,
    statistics_by_textbook,
    sweeps_by_textbook,
    swept_statistics_by_textbook,
)
from tests.agreement.matching import (
    equations_of_pairs_by_kernel,
    equations_of_pairs_by_textbook,
    field_equations_by_kernel,
    field_equations_by_textbook,
    fields_by_kernel,
    fields_by_textbook,
    match_cases,
    prepared_by_kernel,
    prepared_by_textbook,
    refined_both_ways_by_kernel,
    refined_both_ways_by_textbook,
    refined_by_kernel,
    refined_by_textbook,
    searched_by_kernel,
    searched_by_textbook,
    split_by_kernel,
    split_by_textbook,
    step_by_kernel,
    step_by_textbook,
    views_by_kernel,
    views_by_textbook,
)
from tests.agreement.places import (
    described_by_kernel,
    described_by_textbook,
    group_by_search,
    group_by_textbook,
    local_map_by_kernel,
    local_map_by_textbook,
    pair_cases,
    pairs_by_kernel,
    pairs_by_textbook,
)
from tests.agreement.planning import (
    path_by_kernel,
    path_by_textbook,
    planning_cases,
    searched_cells_by_kernel,
    searched_cells_by_textbook,
    spread_by_kernel,
    spread_by_textbook,
)
from tests.agreement.reflection import reflected_by_kernel, reflected_by_textbook, reflection_cases
from tests.agreement.relaxation import relaxed_by_kernel, relaxed_by_textbook, rough_paths
from tests.agreement.sensors import (
    cloud_by_core,
    cloud_by_textbook,
    depth_by_core,
    depth_by_textbook,
)
from tests.agreement.simulation import space_by_kernel, space_by_textbook, space_cases
from tests.agreement.slam import (
    agreement_by_kernel,
    agreement_by_textbook,
    edges_by_kernel,
    edges_by_textbook,
    graph_cases,
    information_by_kernel,
    information_by_textbook,
    nearest_by_kernel,
    nearest_by_textbook,
    solved_by_kernel,
    solved_by_textbook,
    ways_by_kernel,
    ways_by_textbook,
)
from tests.agreement.terrain import (
    consensus_by_kernel,
    consensus_by_textbook,
    ground_by_kernel,
    ground_by_textbook,
    patches_by_kernel,
    patches_by_textbook,
    terrain_cases,
)
from tests.agreement.tsdf import (
    beam_cases,
    beams_in_tsdf_by_kernel,
    beams_in_tsdf_by_textbook,
    depth_cases,
    depths_in_tsdf_by_kernel,
    depths_in_tsdf_by_textbook,
    field_cases,
    mesh_by_kernel,
    mesh_by_textbook,
)
from tests.agreement.volume import (
    asked_by_kernel,
    asked_by_textbook,
    cast_by_kernel,
    cast_by_textbook,
    faces_by_kernel,
    faces_by_textbook,
    inserted_by_kernel,
    inserted_by_textbook,
    tree_by_kernel,
    tree_by_textbook,
    volume_cases,
)


@dataclass(frozen=True)
class Row:
    name: str
    kernel: Callable[[Any], tuple[Any, ...]]
    twin: Callable[[Any], tuple[Any, ...]]
    inputs: st.SearchStrategy[Any]
    tolerance: float = 0.0  #: of floating-point numbers; cells and counts are always equal


_MATCHES = match_cases()
RAMP, CONE, COUNTING, CERTAINTIES = (("smooth_ramp",), ("sonar_cone",), ("hit_counting",), ("moravec_elfes",))
ROUNDING = 1e-6  # exponentials, angles and powers differ in their last bit from library to library

TABLE = (
    Row("bresenham", line_by_kernel, line_by_textbook, lines()),
    Row("exact traversal", ray_by_kernel, ray_by_textbook, rays()),
    Row("per beam", map_by_kernel, map_by_textbook, mapping_cases("per_beam")),
    Row("scan by scan", map_of_single_scans, map_of_single_scans_by_textbook, mapping_cases("per_beam")),
    Row("per scan", map_by_kernel, map_by_textbook, mapping_cases("per_scan")),
    Row("smooth ramp per beam", map_by_kernel, map_by_textbook, mapping_cases("per_beam", RAMP), ROUNDING),
    Row("smooth ramp per scan", map_by_kernel, map_by_textbook, mapping_cases("per_scan", RAMP), ROUNDING),
    Row("sonar cone per beam", map_by_kernel, map_by_textbook, mapping_cases("per_beam", CONE), ROUNDING),
    Row("sonar cone per scan", map_by_kernel, map_by_textbook, mapping_cases("per_scan", CONE), ROUNDING),
    Row(
        "hit counting per beam",
        statistics_by_kernel,
        statistics_by_textbook,
        mapping_cases("per_beam", COUNTING),
        ROUNDING,
    ),
    Row(
        "hit counting per scan",
        statistics_by_kernel,
        statistics_by_textbook,
        mapping_cases("per_scan", COUNTING),
        ROUNDING,
    ),
    Row(
        "Moravec and Elfes",
        statistics_by_kernel,
        statistics_by_textbook,
        mapping_cases("per_beam", CERTAINTIES),
        ROUNDING,
    ),
    Row("provenance", provenance_by_kernel, provenance_by_textbook, mapping_cases("per_beam")),
    Row("provenance of ramps", provenance_by_kernel, provenance_by_textbook, mapping_cases("per_beam", RAMP), ROUNDING),
    Row("provenance of cones", provenance_by_kernel, provenance_by_textbook, mapping_cases("per_beam", CONE), ROUNDING),
    Row(
        "provenance per scan",
        provenance_by_kernel,
        provenance_of_scans_by_textbook,
        mapping_cases("per_scan", (*STEPS, *RAMP, *CONE)),
        ROUNDING,
    ),
    Row(
        "provenance of hits and misses",
        provenance_by_kernel,
        provenance_of_counts_by_textbook,
        mapping_cases("per_beam", COUNTING),
        ROUNDING,
    ),
    Row("deskewed", map_by_kernel, sweeps_by_textbook, sweeping_cases()),
    Row("deskewed ramps", map_by_kernel, sweeps_by_textbook, sweeping_cases(RAMP), ROUNDING),
    Row("deskewed cones", map_by_kernel, sweeps_by_textbook, sweeping_cases(CONE), ROUNDING),
    Row("deskewed counting", statistics_by_kernel, swept_statistics_by_textbook, sweeping_cases(COUNTING), ROUNDING),
    Row(
        "provenance of deskewed beams",
        provenance_of_sweeps_by_kernel,
        provenance_of_sweeps_by_textbook,
        sweeping_cases(),
    ),
    Row("merging", merged_by_core, merged_by_textbook, two_maps(), ROUNDING),
    Row("states and entropy", states_by_core, states_by_textbook, states(), ROUNDING),
    Row("geometry of a log", bounds_by_kernel, bounds_by_textbook, mapping_cases("per_beam")),
    Row("geometry of a deskewed log", bounds_by_kernel, bounds_of_sweeps_by_textbook, sweeping_cases()),
    Row("quantise", picture_by_kernel, picture_by_textbook, pictures()),
    Row("quantise cells", picture_of_cells_by_kernel, picture_by_textbook, pictures()),
    Row("changed cells by tile", sorted_by_kernel, sorted_by_textbook, listed_cells()),
    Row("scan out of a cloud", cloud_by_core, cloud_by_textbook, clouds()),
    Row("scan out of a depth image", depth_by_core, depth_by_textbook, depths()),
    Row("points and normals of scans", prepared_by_kernel, prepared_by_textbook, _MATCHES, 1e-5),
    Row(
        "point-to-line and point-to-point",
        equations_of_pairs_by_kernel,
        equations_of_pairs_by_textbook,
        _MATCHES,
        1e-6,
    ),
    Row("Gauss-Newton step", step_by_kernel, step_by_textbook, _MATCHES, 1e-9),
    Row("refined pose", refined_by_kernel, refined_by_textbook, _MATCHES, 1e-6),
    Row("pairs both ways", refined_both_ways_by_kernel, refined_both_ways_by_textbook, _MATCHES, 1e-6),
    Row("agreement of views", views_by_kernel, views_by_textbook, _MATCHES, 1e-6),
    Row("score field", fields_by_kernel, fields_by_textbook, _MATCHES),
    Row("likelihood field", field_equations_by_kernel, field_equations_by_textbook, _MATCHES, 1e-6),
    Row("split and merge", split_by_kernel, split_by_textbook, _MATCHES),
    Row("correlative search", searched_by_kernel, searched_by_textbook, _MATCHES),
    Row("edges of a pose graph", edges_by_kernel, edges_by_textbook, graph_cases(), 1e-9),
    Row("block Cholesky", solved_by_kernel, solved_by_textbook, graph_cases(), 1e-6),
    Row("ways in a pose graph", ways_by_kernel, ways_by_textbook, graph_cases(), 1e-12),
    Row("nearest node of each submap", nearest_by_kernel, nearest_by_textbook, graph_cases()),
    Row("points that agree and contradict", agreement_by_kernel, agreement_by_textbook, _MATCHES),
    Row("local map of a submap", local_map_by_kernel, local_map_by_textbook, _MATCHES, 1e-6),
    Row("corners and their descriptors", described_by_kernel, described_by_textbook, _MATCHES, 1e-6),
    Row("RANSAC over corners", pairs_by_kernel, pairs_by_textbook, pair_cases(), 1e-9),
    Row("largest consistent group", group_by_search, group_by_textbook, pair_cases()),
    Row("information of an aligned pose", information_by_kernel, information_by_textbook, graph_cases(), 1e-6),
    Row("numbers of the particle filter", numbers_by_filter, numbers_by_textbook, localization_cases(), 1e-9),
    Row("odometry motion model", moved_by_kernel, moved_by_textbook, localization_cases(), 1e-5),
    Row("particles anywhere and around a pose", drawn_by_kernel, drawn_by_textbook, localization_cases(), 1e-5),
    Row("likelihood field of a map", scored_by_kernel, scored_by_textbook, localization_cases(), 2e-3),
    Row("beam range finder model", beams_by_kernel, beams_by_textbook, localization_cases(), 1e-6),
    Row("unexplained readings", unexplained_by_kernel, unexplained_by_textbook, localization_cases()),
    Row("low-variance resampling", resampled_by_kernel, resampled_by_textbook, localization_cases()),
    Row("clusters of particles", clusters_by_kernel, clusters_by_textbook, localization_cases(), 1e-6),
    Row("costs of map values", interpreted_by_table, interpreted_by_textbook, costmap_cases()),
    Row("inflation", inflated_by_kernel, inflated_by_textbook, costmap_cases()),
    Row("marking and clearing", observed_by_kernel, observed_by_textbook, costmap_cases()),
    Row("small groups of obstacles", denoised_by_layer, denoised_by_textbook, costmap_cases()),
    Row("layers laid over each other", laid_by_kernel, laid_by_textbook, costmap_cases()),
    Row("columns of voxels", voxels_by_kernel, voxels_by_textbook, voxel_cases()),
    Row("cost to come by Dijkstra", spread_by_kernel, spread_by_textbook, planning_cases()),
    Row("cost to come by A*", searched_cells_by_kernel, searched_cells_by_textbook, planning_cases()),
    Row("path back", path_by_kernel, path_by_textbook, planning_cases()),
    Row("volume", inserted_by_kernel, inserted_by_textbook, volume_cases()),
    Row("casts in a volume", cast_by_kernel, cast_by_textbook, volume_cases()),
    Row("octree", tree_by_kernel, tree_by_textbook, volume_cases()),
    Row("obstacles and columns of a volume", asked_by_kernel, asked_by_textbook, volume_cases(), tolerance=1e-9),
    Row("signed distances of depth images", depths_in_tsdf_by_kernel, depths_in_tsdf_by_textbook, depth_cases()),
    Row("signed distances of beams", beams_in_tsdf_by_kernel, beams_in_tsdf_by_textbook, beam_cases()),
    Row("mesh of signed distances", mesh_by_kernel, mesh_by_textbook, field_cases(), tolerance=1e-5),
    # A colour of 255 may be rounded to the one beside it.
    Row("parts of a mesh and their light", parts_by_kernel, parts_by_textbook, field_cases(), tolerance=0.005),
    Row("faces of voxels", faces_by_kernel, faces_by_textbook, volume_cases()),
    Row("rays in a world in 3D", space_by_kernel, space_by_textbook, space_cases(), tolerance=1e-9),
    Row("ground of a cloud", ground_by_kernel, ground_by_textbook, terrain_cases()),
    Row("readings as text", text_by_kernel, text_by_encoder, readings()),
    Row("motion of the simulated robot", driven_by_kernel, driven_by_textbook, drives()),
    Row("beams of the simulated lidar", beams_cast_by_kernel, beams_cast_by_textbook, lidars(), tolerance=1e-9),
    Row("readings of the simulated lidar", readings_by_kernel, readings_by_textbook, lidars()),
    Row("relaxed paths of the explorer", relaxed_by_kernel, relaxed_by_textbook, rough_paths()),
    Row("beams that polished walls reflect", reflected_by_kernel, reflected_by_textbook, reflection_cases()),
    Row("points that agree on a patch's plane", consensus_by_kernel, consensus_by_textbook, terrain_cases()),
    Row("planes of patches", patches_by_kernel, patches_by_textbook, terrain_cases(), tolerance=1e-6),
)

_MODELS = tuple(
    row.name
    for row in TABLE
    if row.kernel in {map_by_kernel, map_of_single_scans, statistics_by_kernel}
    or row.kernel in {provenance_by_kernel, provenance_of_sweeps_by_kernel}
)
_MATCHED = tuple(row.name for row in TABLE if row.inputs is _MATCHES)

#: by module of the product, which rows use it on both sides: there they agree whatever it computes
SHARED: dict[str, tuple[str, ...]] = {
    "mapper.costmap.costs": ("inflation",),
    "mapper.costmap.inflation": ("inflation",),  # how many cells a radius has
    "mapper.localization.likelihood_field": (  # which cells are occupied
        "particles anywhere and around a pose",
        "likelihood field of a map",
        "beam range finder model",
        "unexplained readings",
    ),
    "mapper.mapping.integrate": ("scan by scan",),
    "mapper.mapping.scan_batch": ("scan by scan",),
    "mapper.mapping.sensor_model": _MODELS,  # tests/mapper/mapping compares the models with their formulas
    "mapper.mapping.update_plan": ("scan by scan",),
    "mapper.matching.beams": _MATCHED,  # the scans of a case
    "mapper.matching.fields": _MATCHED,
    "mapper.simulation.plan_map": ("rays in a world in 3D",),  # the heights of the world's things
    "mapper.simulation.sensors_3d": ("rays in a world in 3D",),
    "mapper.simulation.worlds": ("relaxed paths of the explorer",),
    "mapper.terrain.ground": ("planes of patches",),
    "mapper.terrain.patches": ("planes of patches",),
    "mapper.volume.blocks": ("parts of a mesh and their light", "faces of voxels"),
    "mapper.volume.mesh.cube_cases": ("mesh of signed distances", "parts of a mesh and their light"),
    "mapper.volume.mesh.faces": ("faces of voxels",),
    "mapper.volume.mesh.mesh": ("mesh of signed distances", "parts of a mesh and their light"),
    "mapper.volume.mesh.meshing": ("parts of a mesh and their light",),  # the mesh whose parts are made
    "mapper.volume.occupancy.stop_masks": ("faces of voxels",),
    "mapper.volume.occupancy.volume": ("faces of voxels",),  # the map whose faces are asked for
    "mapper.volume.surface.tsdf": ("parts of a mesh and their light",),
}
