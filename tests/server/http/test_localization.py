"""A log localized in a map over HTTP: the map is chosen, the job's poses become a trajectory, its course is shown."""

from __future__ import annotations

import io
import tarfile
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mapper.grid import OccupancyGrid
from mapper.io.export import write_mcap
from mapper.io.maps import save_map
from mapper.io.trajectories import read_tum
from mapper.localization import LocalizationConfig, amcl_yaml
from mapper.sensors.scan import ScanLog
from server.library.packs.filter_states import read_filter_states
from server.parts.costmap.part import CostmapPart
from server.parts.localization.logged import LogLocalization
from server.parts.wire import command_of
from server.sessions.parts import Recording
from tests.mapper.localization.rooms import office, two_lidars
from tests.server.cli.poses.test_slam import carmen as written
from tests.server.library.processing import slam_stand_ins as stand_ins
from tests.server.sent import sent_one
from tests.server.service import Service, once_read, running, settings_for, until

FEW = {"global_particles": 8000}


@pytest.fixture(scope="module")
def drive() -> ScanLog:
    return office()[1]


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service whose jobs run on threads of this process, without its limits, but for the reading of logs."""
    with pytest.MonkeyPatch.context() as patch:
        worker_at = __import__("server.jobs.workers", fromlist=["worker_at"]).worker_at
        made: list[Any] = []

        def first_a_real_one(*given: Any) -> Any:
            made.append(stand_ins.ThreadWorker() if made else worker_at(*given))
            return made[-1]

        patch.setattr("server.library.library.worker_at", first_a_real_one)
        patch.setattr("server.library.processing.localization.EVERY_S", 0.0)
        with running(settings_for(tmp_path_factory.mktemp("service"))) as service:
            yield service


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("office")
    save_map(office()[0], folder / "office", "trinary")
    return folder


@pytest.fixture(scope="module")
def session(service: Service, files: Path, drive: ScanLog) -> str:
    log = written(files / "office.log", drive).read_bytes()
    log_id = str(service.http.put("/api/logs", params={"name": "office.log"}, content=log).json()["id"])
    once_read(service.http, log_id)
    return service.begin(kind="log", log=log_id, playing=False)


def tarred(*paths: Path, names: tuple[str, ...] = ()) -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w") as archive:
        for path, name in zip(paths, names or [path.name for path in paths], strict=True):
            archive.add(path, name)
    return out.getvalue()


def choose(service: Service, session: str, body: bytes, name: str = "office.yaml") -> Any:
    return service.http.put(f"/api/sessions/{session}/localization/map-files", params={"name": name}, content=body)


def recording_of(service: Service, session: str) -> Recording:
    recording = service.state.sessions.get(session).model.find(Recording)
    assert recording is not None
    return recording


def until_shown(recording: Recording) -> None:
    """Wait for the map of all scans along the trajectory that was added, not one that a filter is still making."""

    def is_shown() -> bool:
        name = "localized"
        if recording.trajectory != name or recording.view().index != recording.log.n_scans:
            return False
        return recording.log.trajectory(name).description.startswith("localized in")

    until(is_shown)


def layers(service: Service, session: str) -> list[str]:
    return [layer.name for layer in service.state.sessions.get(session).model.layers]


def test_a_map_of_the_library_is_the_terrain_of_the_costmap(service: Service, session: str, files: Path) -> None:
    http, address = service.http, f"/api/sessions/{session}/costmap/terrain"
    body = tarred(files / "office.yaml", files / "office.pgm")
    map_id = str(http.put("/api/logs", params={"name": "slopes.yaml"}, content=body).json()["id"])
    once_read(http, map_id)
    made = http.put(address, json={"log": map_id})
    assert (made.status_code, made.json()["map"]["title"]) == (200, "slopes.yaml")
    service.state.sessions.get(session).enqueue(command_of({"type": "costmap"}))
    until(lambda: "terrain_layer" in layers(service, session))
    assert http.put(address, json={"log": None}).json() == {"map": None}
    until(lambda: "terrain_layer" not in layers(service, session))
    refused = http.put(address, json={"log": recording_of(service, session).log_id})
    assert (refused.status_code, refused.json()["code"]) == (422, "terrain.no_map")
    assert http.put(address, json={"log": "none"}).status_code == 404
    service.state.sessions.get(session).enqueue(command_of({"type": "costmap", "value": False}))


def test_a_cloud_is_the_terrain_of_the_costmap_and_of_a_link_to_it(service: Service, session: str) -> None:
    """Of a flat floor around the robot with a wall of 1 m on it, the floor is safe and the wall lethal."""
    http, address = service.http, f"/api/sessions/{session}/costmap/terrain"
    host: Any = service.state.sessions.get(session)
    at = np.array(host.model.find(Recording).robot_state().pose[:2])
    steps = np.arange(-2.0, 2.0, 0.04)
    floor = np.column_stack([axis.ravel() for axis in np.meshgrid(steps, steps)])
    heights = np.where(np.abs(floor[:, 0] - 1.0) < 0.3, 1.0, 0.0)
    lines = [f"{x:.3f} {y:.3f} {z:.3f}" for (x, y), z in zip(floor + at, heights, strict=True)]
    body = "\n".join(lines).encode()
    cloud = str(http.put("/api/logs", params={"name": "floor.xyz"}, content=body).json()["id"])
    assert once_read(http, cloud)["state"] == "ready"
    made = http.put(address, json={"log": cloud})
    assert made.status_code == 200, made.text
    found = made.json()["map"]
    assert found["title"] == "floor.xyz"
    assert found["classes"]["safe"] > 3 * found["classes"]["unsafe"] > 0
    np.testing.assert_allclose(found["origin"][:2], at - 2.0, atol=0.01)

    only = dict.fromkeys(("static_layer", "obstacle_layer", "dynamic_layer", "inflation_layer"), False)
    host.enqueue(command_of({"type": "costmap", "values": only | {"terrain_layer": True}}))
    until(lambda: host.model.find(CostmapPart).present_costs() is not None)
    wall, free = at + np.array([1.0, 0.5]), at + np.array([-1.0, 0.5])

    def cost(of: Any, place: Any) -> int:
        costs = of.model.find(CostmapPart).present_costs()  # none while another configuration is computed
        return 256 if costs is None else int(costs.costs[tuple(costs.geometry.world_to_cell(place))])

    until(lambda: cost(host, wall) == 254 and cost(host, free) < 128)  # the other layers are left out a tick later
    token = http.post(f"/api/sessions/{session}/links", json={}).json()["token"]
    opened: Any = service.state.sessions.get(http.post(f"/api/shared/{token}/sessions").json()["id"])
    until(lambda: opened.model.find(CostmapPart).present_costs() is not None)
    until(lambda: cost(opened, wall) == 254)
    # Without the cloud the link opens without terrain.
    assert http.delete(f"/api/logs/{cloud}").status_code in (200, 204)
    bare: Any = service.state.sessions.get(http.post(f"/api/shared/{token}/sessions").json()["id"])
    until(lambda: bare.model.find(CostmapPart).present_costs() is not None)
    assert "terrain_layer" not in [layer.name for layer in bare.model.layers]
    http.put(address, json={"log": None})
    host.enqueue(command_of({"type": "costmap", "value": False}))


def test_a_log_is_localized_in_map_files(service: Service, session: str, files: Path, drive: ScanLog) -> None:
    http, address = service.http, f"/api/sessions/{session}/localization"
    assert http.get(f"{address}/map").json() == {"map": None}
    refused = http.post(address, json={})
    assert (refused.status_code, refused.json()["code"]) == (422, "localization.no_map")
    answer = choose(service, session, tarred(files / "office.yaml", files / "office.pgm"))
    assert answer.status_code == 200, answer.text
    chosen = answer.json()["map"]
    assert (chosen["title"], chosen["resolution"]) == ("office.yaml", 0.05)
    until(lambda: "given_map" in layers(service, session))
    assert http.get(f"{address}/map").json() == {"map": chosen}
    assert http.get(f"{address}/course").json() == {"course": None}

    refused = http.post(address, json={"parameters": {"z_hot": 1}})
    assert refused.status_code == 422
    assert "z_hot" in refused.json()["message"]
    begun = http.post(address, json={"parameters": FEW})
    assert begun.status_code == 202, begun.text
    state = until(lambda: (one := http.get(address).json())["state"] not in ("queued", "running") and one)
    assert (state["state"], state["error"]) == ("done", None)
    assert state["parameters"] == {"values": {"global_particles": 8000.0}, "initial_pose": None}
    result = state["result"]
    assert result["trajectory"] == "localized"
    assert result["is_converged"]

    recording = recording_of(service, session)
    until_shown(recording)
    text = http.get(f"/api/sessions/{session}/trajectories/localized").text
    (files / "found.tum").write_text(text)
    off = read_tum(files / "found.tum").poses[:, :2] - drive.trajectory("true").poses[:, :2]
    assert np.hypot(*off[-10:].T).max() < 0.4
    course = http.get(f"{address}/course").json()["course"]
    assert course["first_converged"] == result["first_converged"]
    assert course["deviation_m"][0] > 1.0 > 5 * course["deviation_m"][-1]
    assert len(course["scans"]) == drive.n_scans
    until(lambda: "particles" in layers(service, session))

    model: Any = service.state.sessions.get(session).model
    message = sent_one(model.find(LogLocalization).message())
    assert message["is_on"]
    assert message["is_converged"]
    assert message["pose"] == [round(v, 4) for v in recording.log.trajectory("localized").poses[-1].tolist()]
    for name, is_on in (
        (next(one for one in recording.log.trajectories if one != "localized"), False),
        ("localized", True),
    ):
        service.state.sessions.get(session).enqueue(command_of({"type": "trajectory", "name": name}))
        until(partial(lambda name: recording.trajectory == name, name))
        assert model.find(LogLocalization).message().is_on is is_on


def test_a_log_is_localized_by_two_lidars(service: Service, files: Path, drive: ScanLog) -> None:
    out = io.BytesIO()
    both = two_lidars(replace(drive, trajectories={"true": drive.trajectory("true")}))
    write_mcap(out, both)
    http = service.http
    log_id = str(http.put("/api/logs", params={"name": "run.mcap"}, content=out.getvalue()).json()["id"])
    once_read(http, log_id)
    session = service.begin(kind="log", log=log_id, topic="/right + /left", playing=False)
    assert choose(service, session, tarred(files / "office.yaml", files / "office.pgm")).status_code == 200
    address = f"/api/sessions/{session}/localization"
    assert http.post(address, json={"parameters": FEW}).status_code == 202
    state = until(lambda: (one := http.get(address).json())["state"] not in ("queued", "running") and one)
    assert (state["state"], state["error"]) == ("done", None)
    recording = recording_of(service, session)
    until_shown(recording)
    assert recording.log.n_scans == 2 * drive.n_scans
    off = recording.log.trajectory("localized").poses - both.trajectory("true").poses
    assert np.hypot(*off[-10:, :2].T).max() < 0.4
    course = http.get(f"{address}/course").json()["course"]
    assert len(course["scans"]) == 2 * drive.n_scans


def test_scans_of_a_robot_that_was_not_found_are_in_no_map(service: Service, files: Path, drive: ScanLog) -> None:
    http, short = service.http, written(files / "short.log", drive.take(slice(0, 2)))
    log_id = str(http.put("/api/logs", params={"name": "short.log"}, content=short.read_bytes()).json()["id"])
    once_read(http, log_id)
    session = service.begin(kind="log", log=log_id, playing=False)
    assert choose(service, session, tarred(files / "office.yaml", files / "office.pgm")).status_code == 200
    address = f"/api/sessions/{session}/localization"
    assert http.post(address, json={"parameters": FEW}).status_code == 202
    state = until(lambda: (one := http.get(address).json())["state"] not in ("queued", "running") and one)
    assert (state["state"], state["error"]) == ("done", None)
    assert (state["result"]["first_converged"], state["result"]["left_out"]) == (None, 2)
    recording = recording_of(service, session)
    until_shown(recording)
    assert not recording.replay.grid.observed.any()
    (note,) = [one for one in recording.log.notes if "left out" in one]
    assert note.startswith("All scans are left out of maps along 'localized'")


def be_localized(service: Service, session: str, files: Path) -> None:
    """Localize the log of a session, unless an earlier test did: tests of a module may run in another order."""
    http, address = service.http, f"/api/sessions/{session}/localization"
    if http.get(f"/api/sessions/{session}/trajectories/localized").status_code == 200:
        return
    assert choose(service, session, tarred(files / "office.yaml", files / "office.pgm")).status_code == 200
    assert http.post(address, json={"parameters": FEW}).status_code == 202
    until(lambda: http.get(address).json()["state"] == "done")
    until_shown(recording_of(service, session))


def test_the_course_has_the_particles_of_each_scan_that_was_used(
    service: Service, session: str, files: Path, drive: ScanLog
) -> None:
    be_localized(service, session, files)
    library, of = service.state.library, service.state.sessions.get(session)
    log_id = recording_of(service, session).log_id
    added = next(one for one in library.trajectories.of(of.owner, log_id) if one.name == "localized")
    assert (added.source, added.has_graph) == ("localized", False)
    path = next(service.state.settings.data_dir.rglob(f"{added.id}.course"))
    states = read_filter_states(path.read_bytes())
    assert len(states.offsets) == states.is_updated.sum() + 1
    assert states.is_updated[0]
    cloud, poses = states.cloud(drive.n_scans - 1), recording_of(service, session).log.trajectory("localized").poses
    assert np.hypot(*(cloud[:, :2] - poses[-1, :2]).T).mean() < 0.5
    assert len(states.cloud(0)) > 100
    assert np.ptp(states.cloud(0)[:, 0]) > 5.0, "everywhere at first"


def test_it_starts_at_a_pose_in_another_log_s_map(service: Service, session: str, files: Path, drive: ScanLog) -> None:
    http, address = service.http, f"/api/sessions/{session}/localization"
    be_localized(service, session, files)
    own = recording_of(service, session).log_id
    made = http.put(f"{address}/map", json={"log": own, "trajectory": "localized"})
    assert made.json()["map"]["title"] == "office.log, localized"
    wrong = http.put(f"{address}/map", json={"log": own, "trajectory": "gps"})
    assert wrong.json()["code"] == "log.trajectory"
    assert http.put(f"{address}/map", json={"log": "none"}).status_code == 404
    pose = drive.trajectory("true").poses[0].tolist()
    assert http.post(address, json={"initial_pose": [0.0, None, 0.0]}).status_code == 422
    http.post(address, json={"initial_pose": [1e5, 0.0, 0.0]})
    state = until(lambda: (one := http.get(address).json())["state"] not in ("queued", "running") and one)
    assert state["error"]["code"] == "localization.pose_outside"
    http.post(address, json={"initial_pose": pose})
    state = until(lambda: (one := http.get(address).json())["state"] not in ("queued", "running") and one)
    assert (state["state"], state["error"]) == ("done", None)
    assert state["result"]["first_converged"] <= 1
    owner = service.state.sessions.get(session).owner
    assert "from a given pose" in service.state.library.trajectories.get(owner, own, "localized").description


@pytest.mark.parametrize(
    ("names", "code"),
    [
        (("office.yaml",), "map.image_missing"),
        (("office.pgm",), "map.files"),
        (("office.yaml", "office.pgm", "office.yaml", "more.yaml"), "map.files"),
    ],
)
def test_what_is_no_map_is_refused(
    service: Service, session: str, files: Path, names: tuple[str, ...], code: str
) -> None:
    body = tarred(*(files / ("office" + Path(name).suffix) for name in names), names=names)
    refused = choose(service, session, body)
    assert (refused.status_code, refused.json()["code"]) == (422, code)


def test_a_file_that_leaves_its_folder_is_kept_in_it(service: Service, session: str, files: Path) -> None:
    body = tarred(files / "office.yaml", files / "office.pgm", names=("../../office.yaml", "/tmp/office.pgm"))
    assert choose(service, session, body).json()["map"]["title"] == "office.yaml"
    assert choose(service, session, b"no tar at all").json()["code"] == "map.files"


def test_amcl_yamls_go_in_and_come_out(service: Service) -> None:
    http = service.http
    names = {row["name"] for row in http.get("/api/localization/parameters").json()["table"]}
    assert {"alpha1", "z_hit", "laser_max_beams"} <= names
    values = {"alpha1": 0.4, "laser_model_type": "beam"}
    text = http.post("/api/localization/amcl.yaml", json=values).text
    assert text == amcl_yaml(LocalizationConfig().with_values(values))
    read = http.put("/api/localization/parameters", content=text).json()
    assert read == {"values": values, "layout": "nav2", "others": {}, "notes": []}
    (note,) = http.put("/api/localization/parameters", content="/amcl: {ros__parameters: {z_hot: 1}}").json()["notes"]
    assert "no parameter 'z_hot' (did you mean 'z_short'?)" in note
    refused = http.put("/api/localization/parameters", content="amcl:\n  ros__parameters:\n    alpha1: -2\n")
    assert refused.status_code == 422
    assert "alpha1" in refused.json()["message"]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("z_hit: .nan", "(z_hit) must be a finite number"),
        ("min_particles: 5000", "must be at most max_particles"),
    ],
)
def test_an_amcl_yaml_with_an_error_is_refused(service: Service, line: str, said: str) -> None:
    refused = service.http.put("/api/localization/parameters", content=f"amcl:\n  ros__parameters:\n    {line}\n")
    assert refused.status_code == 422
    assert said in refused.json()["message"]


def test_a_map_without_free_cells_ends_the_job_with_a_sentence(service: Service, session: str, tmp_path: Path) -> None:
    grid = OccupancyGrid(office()[0].geometry)
    grid.log_odds[:], grid.observed[:] = 3.5, True
    save_map(grid, tmp_path / "full", "trinary")
    http, address = service.http, f"/api/sessions/{session}/localization"
    before = http.get(f"/api/sessions/{session}/trajectories/localized").text
    assert (
        choose(service, session, tarred(tmp_path / "full.yaml", tmp_path / "full.pgm"), "full.yaml").status_code == 200
    )
    http.post(address, json={})
    state = until(lambda: (one := http.get(address).json())["state"] not in ("queued", "running") and one)
    assert (state["state"], state["error"]["code"]) == ("failed", "localization.no_free_cells")
    assert "The map has no free cells" in state["error"]["message"]
    assert http.get(f"/api/sessions/{session}/trajectories/localized").text == before


def test_what_changes_nothing_in_an_amcl_yaml_comes_out_as_it_went_in(service: Service) -> None:
    text = "odom_alpha1: 0.4\nodom_frame_id: wheels\ninitial_pose_x: 2.5\n"
    read = service.http.put("/api/localization/parameters", content=text).json()
    assert read["layout"] == "ros1"
    assert read["others"] == {"odom_frame_id": "wheels", "initial_pose_x": 2.5}
    wanted = read["values"] | read["others"]
    saved = service.http.post("/api/localization/amcl.yaml", params={"layout": "ros1"}, json=wanted)
    assert service.http.put("/api/localization/parameters", content=saved.text).json() == read
    refused = service.http.post("/api/localization/amcl.yaml", json={"robot": 1})
    assert refused.status_code == 422
    assert "'robot'" in refused.json()["message"]


def test_a_simulation_is_not_localized_here(service: Service) -> None:
    session = service.begin()
    assert service.http.get(f"/api/sessions/{session}/localization").json()["code"] == "session.not_a_log"
    assert service.http.get(f"/api/sessions/{session}/localization/course").json()["code"] == "session.not_a_log"
