"""The job that merges two logs, in this process: what it leaves are poses in one frame."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from mapper.evaluation import absolute_errors, align
from mapper.io.logs import open_log
from mapper.io.trajectories import read_tum
from mapper.sensors.joint_log import JointLog
from mapper.sensors.robot_log import RobotLog
from mapper.slam import merge_logs, merged_graph
from mapper.slam.merged_log import merged_log
from server.jobs.process import JobLimits
from server.library.packs.graph import read_graph
from server.library.packs.log import write_pack
from server.library.processing.merging import BOTH, ENDINGS, GRAPH, LOG, STAGE, MergeJob
from tests.mapper.slam.test_merge import FIRST, SECOND, WIDE, in_frame
from tests.mapper.slam.worlds import along, drive


def test_it_leaves_a_trajectory_of_each_log_in_one_frame(tmp_path: Path) -> None:
    first = in_frame(drive("loop", along([*FIRST, (22.7, 1.25), (22.7, 4.0)], 0.4), sensor=WIDE), (3.0, 1.0, 0.3))
    second = in_frame(drive("loop", along(SECOND, 0.4), seed=8), (-4.0, 9.0, 2.5))
    packs = []
    for name, log in (("first", first), ("second", second)):
        packs.append(tmp_path / f"{name}.npz")
        write_pack(RobotLog.of_one(log), packs[-1])
    outcome = MergeJob(str(packs[0]), str(packs[1]), str(tmp_path / "out"), JobLimits()).compute()
    assert 3 <= outcome.loops <= outcome.tried
    poses = [read_tum(tmp_path / f"out{ending}") for ending in ENDINGS]
    for log, own in zip((first, second), poses, strict=True):
        np.testing.assert_array_equal(own.stamps_ns, log.stamps_ns)
    true = np.concatenate([log.trajectory("true").poses for log in (first, second)])
    found = np.concatenate([own.poses for own in poses])
    assert absolute_errors(true, align(true, found).apply(found))[0].max() < 0.2
    assert (tmp_path / f"out{STAGE}").read_text() == "writing"
    # The log of both, as its own reader has it: the lidars differ, and both began at one time.
    both = open_log(tmp_path / f"out{LOG}", topic="/second/scan_0")
    assert outcome.topic == "/first/scan_0 + /second/scan_0"
    assert "the second log’s clock is set" in outcome.note
    assert both.stamps_ns[0] > first.stamps_ns[-1]
    np.testing.assert_array_equal(both.ranges, second.ranges)
    np.testing.assert_allclose(both.trajectory().poses, poses[1].poses, atol=1e-5)
    assert both.mount == second.mount
    # Its graph has the scans of both logs, the second one's behind the first one's.
    graph, tried = read_graph((tmp_path / f"out{GRAPH}").read_bytes())
    whole = read_tum(tmp_path / f"out{BOTH}")
    np.testing.assert_allclose(graph.poses, whole.poses[graph.nodes], atol=1e-5)
    assert len(whole.poses) == first.n_scans + second.n_scans
    between = (graph.nodes[graph.i] < first.n_scans) & (graph.nodes[graph.j] >= first.n_scans)
    assert between.sum() == outcome.loops <= tried.accepted.sum()


def test_the_graph_of_both_follows_the_order_of_their_times() -> None:
    first = drive("loop", along([*FIRST, (22.7, 1.25)], 0.4))
    second = drive("loop", along(SECOND, 0.4), seed=8)
    later = replace(first, stamps_ns=first.stamps_ns + 10**13)
    merged = merge_logs(first, second, guess=np.zeros(3))
    graph, _ = merged_graph((first, second), merged)
    turned, tried = merged_graph((later, second), merged)
    np.testing.assert_array_equal(turned.nodes, np.sort(turned.nodes))
    both, _ = merged_log((later, second), merged.poses)
    np.testing.assert_allclose(turned.poses, both.trajectory().poses[turned.nodes], atol=1e-9)
    assert sorted(turned.residual) == sorted(graph.residual)
    assert (turned.nodes[tried.j] < second.n_scans).any()


def test_alike_lidars_become_one_sensor() -> None:
    log = drive("room", along([(1.5, 2.0), (3.0, 2.0)], 0.5))
    later = replace(log, stamps_ns=log.stamps_ns + 3_600_000_000_000)
    poses = log.trajectory("true").poses
    for pair in ((log, later), (later, log)):  # the earlier one's scans are first
        both, note = merged_log(pair, (poses, poses + 1.0))
        assert (both.n_scans, both.topic, note) == (2 * log.n_scans, "/scan", "")
        np.testing.assert_array_equal(both.stamps_ns, np.concatenate([log.stamps_ns, later.stamps_ns]))
        begin = poses[0] + (0.0 if pair[0] is log else 1.0)
        np.testing.assert_array_equal(both.trajectory().poses[0], begin)
    turned, note = merged_log((log, replace(log, mount=(0.0, 0.0, 1.0))), (poses, poses))
    assert isinstance(turned, JointLog)
    assert "clock is set +1.200 s" in note
    assert turned.stamps_ns[log.n_scans] - log.stamps_ns[-1] == 1_000_000_000
