"""A fleet of logs: each done once, failures listed, resumed; on this machine and on a Dask cluster with TLS."""

from __future__ import annotations

import json
import re
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import dask
import pytest
from distributed import LocalCluster
from distributed.security import Security

from mapper.core.errors import ConfigError, MapperError
from mapper.io.maps import load_map
from mapper.sensors.scan import ScanLog
from server.fleet import Fleet, Result, workers_at
from server.fleet.page import ORDERS, line_of, ordered, write_page
from server.library.processing.fleet.fleet_job import FleetFinding, LogOptions, MapFacts
from tests.server.library.small_logs import carmen

FACTS = MapFacts(
    scans=3,
    beams=2,
    trajectory="odometry",
    rows=10,
    cols=20,
    resolution=0.05,
    contrast=None,
    drift_m=0.456,
    findings=(
        FleetFinding("time", "The time <runs> backwards.", possible=False),
        FleetFinding("drift", "The poses drift.", possible=True),
    ),
    picture=False,
    cpu_s=0.1,
)


class StandIn:
    """A worker that ends the process of some logs."""

    pid, progress = 0, 0.0

    def __init__(self, dies: Callable[[str], bool] = lambda _: False) -> None:
        self.done: list[str] = []
        self.options: list[LogOptions] = []
        self.dies = dies

    async def prepare(self) -> None:
        """It is there."""

    def submit(self, job: Any) -> Future[Any]:
        out: Future[Any] = Future()
        self.done.append(job.source)
        self.options.append(job.options)
        if self.dies(job.source):
            out.set_exception(BrokenExecutor("killed"))
        else:
            out.set_result(FACTS)
        return out

    def end(self) -> None:
        """Nothing runs."""

    close = end


def logs(folder: Path, count: int) -> list[Path]:
    paths = [folder / f"{n}.log" for n in range(count)]
    for path in paths:
        path.write_bytes(carmen(5))
    return paths


def run(fleet: Fleet, *workers: Any, again: bool = False) -> list[Result]:
    told: list[Result] = []
    with fleet.held():
        fleet.run(workers, told.append, again=again)
    return told


def test_each_log_is_done_once_however_many_workers_there_are(tmp_path: Path) -> None:
    paths = logs(tmp_path, 60)
    workers = [StandIn() for _ in range(8)]
    fleet = Fleet([*paths, paths[0]], tmp_path / "out")
    assert len(run(fleet, *workers)) == 60
    assert sorted(one for worker in workers for one in worker.done) == sorted(map(str, paths))
    assert len(list((tmp_path / "out" / "results").iterdir())) == 60
    later = StandIn()
    assert run(Fleet(paths, tmp_path / "out"), later) == []
    assert later.done == []
    paths[7].write_bytes(carmen(6))
    assert [one.log for one in run(Fleet(paths, tmp_path / "out"), later)] == [str(paths[7])], "it is another log now"


def test_logs_are_read_with_the_same_options_and_have_other_results_with_others(tmp_path: Path) -> None:
    path = logs(tmp_path, 1)[0]
    moved = LogOptions("FLASER", None, "scan", {"mount_yaw": 1.5, "time_offset": 0.5})
    first, second = StandIn(), StandIn()
    for _ in range(2):  # the second time both are there
        run(Fleet([path], tmp_path / "out"), first)
        run(Fleet([path], tmp_path / "out", options=moved), second)
    assert first.done == second.done == [str(path)]
    assert (first.options, second.options) == ([LogOptions()], [moved])


def test_the_options_of_a_fleet_are_those_of_a_log(tmp_path: Path) -> None:
    path = logs(tmp_path, 1)[0]

    def read(options: LogOptions) -> ScanLog:
        return options.read(path, lambda _: None)

    plain = read(LogOptions())
    moved = read(LogOptions("FLASER", None, "scan", {"mount_yaw": 1.5, "time_offset": 0.5}))
    assert moved.default_trajectory == "scan"
    assert moved.mount[2] - plain.mount[2] == pytest.approx(1.5)
    assert moved.trajectory().poses[0, 0] - plain.trajectory("scan").poses[0, 0] == pytest.approx(0.5), "at 1 m/s"
    for other, code in ((LogOptions(trajectory="gps"), "log.trajectory"), (LogOptions("RLASER"), "log.topic")):
        with pytest.raises(MapperError) as caught:
            read(other)
        assert caught.value.code == code


def test_an_interrupted_run_goes_on_and_failures_are_done_again_when_asked(tmp_path: Path) -> None:
    paths = logs(tmp_path, 10)
    fleet = Fleet(paths, tmp_path / "out")

    def interrupt(_: Result) -> None:
        if len(fleet.results) == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), fleet.held():
        fleet.run([StandIn()], interrupt)
    bad = StandIn(lambda source: source.endswith(("8.log", "9.log")))
    rest = Fleet(paths, tmp_path / "out")
    told = run(rest, bad)
    assert len(told) == 6
    assert [(one.log, one.code, one.runs) for one in told if one.failed] == [
        (str(paths[8]), "fleet.died", 2), (str(paths[9]), "fleet.died", 2),
    ]  # fmt: skip
    assert run(Fleet(paths, tmp_path / "out"), StandIn()) == []
    mended = run(Fleet(paths, tmp_path / "out"), StandIn(), again=True)
    assert [(one.log, one.failed) for one in mended] == [(str(paths[8]), False), (str(paths[9]), False)]


def test_a_later_run_reads_the_results_that_are_there_also_those_of_versions_without_drift(tmp_path: Path) -> None:
    paths = logs(tmp_path, 2)
    fleet = Fleet(paths, tmp_path / "out")
    run(fleet, StandIn(lambda source: source.endswith("1.log")))
    later = Fleet(paths, tmp_path / "out")
    with later.held():
        assert later.results == fleet.results
    file = tmp_path / "out" / "results" / f"{next(iter(fleet.logs))}.json"
    stored = json.loads(file.read_text())
    del stored["facts"]["drift_m"]
    file.write_text(json.dumps(stored))
    with later.held():
        assert later.results[file.stem].facts == replace(FACTS, drift_m=None)


def test_a_folder_is_held_by_one_run(tmp_path: Path) -> None:
    with Fleet([], tmp_path).held(), pytest.raises(ConfigError) as caught, Fleet([], tmp_path).held():
        pass
    assert caught.value.code == "fleet.held"


def test_the_page_lists_maps_and_failures_and_quotes_names(tmp_path: Path) -> None:
    nasty = tmp_path / "<b>&.log"
    nasty.write_bytes(carmen(5))
    fleet = Fleet([*logs(tmp_path, 2), nasty], tmp_path / "out")
    run(fleet, StandIn(lambda source: "<b>" in source))
    write_page(fleet, running=False)
    text = (tmp_path / "out" / "index.html").read_text()
    assert "<h1>3 of 3 logs, ended</h1>" in text
    assert "Failed: 1" in text
    assert "&lt;b&gt;&amp;.log" in text
    assert "<p>Drift 0.46 m</p><p>3 scans, 1 × 1 m</p><p>The time &lt;runs&gt; backwards.</p>" in text
    assert "1 more finding</summary><ul><li>Possibly: The poses drift.</li>" in text
    assert f'<a href="{(tmp_path / "0.log").as_uri()}">0.log</a>' in text
    assert "<b>&." not in text
    assert "location.reload" not in text
    assert not re.search(r"https?://", text), "it asks no other host"


def test_logs_are_ordered_and_told_in_lines() -> None:
    def one(name: str, drift_m: float | None, contrast: float | None, *findings: FleetFinding) -> Result:
        facts = replace(FACTS, drift_m=drift_m, contrast=contrast, findings=findings)
        return Result(name, f"/logs/{name}", 1.0, 1, facts)

    results = [one("c", None, 0.5), one("a", 0.1, None, FACTS.findings[1]), one("b", 2.0, 0.25, *FACTS.findings)]
    failed = Result("d", "/logs/d", 1.0, 1, None, "code", "words")
    assert [found.key for found, _ in ordered([*results, failed])] == ["a", "b", "c"]
    orders = {order: "".join(found.key for found, _ in ordered(results, order)) for order in ORDERS}
    assert orders == {"drift": "bac", "findings": "bac", "sharpness": "bca", "scans": "abc", "size": "abc"}
    assert [line_of(*found) for found in ordered(results)] == [
        "/logs/a: Drift 0.10 m, 3 scans, 1 × 1 m. Possibly: The poses drift.",
        "/logs/b: Drift 2.00 m, sharpness 0.25, 3 scans, 1 × 1 m. The time <runs> backwards. And 1 more.",
        "/logs/c: Drift not measured, sharpness 0.50, 3 scans, 1 × 1 m. No findings.",
    ]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Security]]:
    security = Security.temporary()
    with LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, security=security, protocol="tls://",
        dashboard_address="127.0.0.1:0", host="127.0.0.1",
    ) as running:  # fmt: skip
        yield running.scheduler_address, security


def test_logs_are_read_examined_and_mapped_on_a_cluster_with_tls(
    cluster: tuple[str, Security], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    address, security = cluster
    good, bad = tmp_path / "good.log", tmp_path / "bad.log"
    good.write_bytes(carmen(30))
    bad.write_bytes(b"Dear all,\n")
    with pytest.raises(ConfigError) as caught, workers_at(address, None, 1 << 30):
        pass
    assert caught.value.code == "fleet.dask", "without the certificates"
    tls = security.get_tls_config_for_role("client")
    given = {"ca-file": tls["ca_file"], "client.cert": tls["cert"], "client.key": tls["key"]}
    fleet = Fleet([good, bad, tmp_path / "none.log"], tmp_path / "out")
    with (
        dask.config.set({f"distributed.comm.tls.{name}": value for name, value in given.items()}),
        fleet.held(),
        workers_at(address, 2, 4 << 30) as workers,
    ):
        fleet.run(workers, lambda _: None)
    results = {Path(one.log).name: one for one in fleet.results.values()}
    assert results["bad.log"].code == "log.unknown_format"
    assert results["none.log"].failed
    facts = results["good.log"].facts
    assert facts is not None
    assert (facts.scans, facts.beams) == (30, 3)
    made = load_map(tmp_path / "out" / "maps" / f"{results['good.log'].key}.yaml")
    assert made.grid.geometry.rows == facts.rows
    assert threading.active_count() < 100
