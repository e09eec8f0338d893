"""The report on a log: what it states, from the command line and over HTTP."""

from __future__ import annotations

import base64
import io
import json
import re
from collections.abc import Mapping
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
from PIL import Image
from pypdf import PdfReader
from typer.testing import CliRunner

from server.cli import app
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.contents.test_pictures import image
from tests.mapper.io.logs import recorded
from tests.server.service import once_read, running, settings_for, until


class _Page(HTMLParser):
    """Addresses that a page would fetch, and its text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.texts: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag != "script"
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def recording() -> bytes:
    camera = image(np.full((48, 64), 200, dtype=np.uint8), "mono8", T0)
    return recorded.mcap_bytes([*robot(3), camera])


def check(page: str) -> list[str]:
    """Assert what each report of the recording has; return its text."""
    found = _Page(page)
    pictures = [one.partition(";base64,") for one in found.addresses]
    assert [kind for kind, _, _ in pictures] == ["data:image/png", "data:image/jpeg"]  # the map, and the camera
    maps, camera = (Image.open(io.BytesIO(base64.b64decode(data))) for _, _, data in pictures)
    assert camera.size == (64, 48)
    # Walls 2 m from the path, which is 1.45 m long, in cells of 0.05 m.
    assert 40 < maps.size[0] < 120
    text = found.texts
    for heading in ("Facts", "Events", "Findings", "Map", "Drift", "Camera", "Parameters of the map", "Versions"):
        assert heading in text
    assert "30, 10.3 a second" in text or "30, 10.0 a second" in text
    assert not re.search(r"https?://", page)
    return text


def check_pdf(data: bytes) -> None:
    """Check by another tool's reader that a PDF has the report on pages of A4, with its pictures."""
    pages = PdfReader(io.BytesIO(data)).pages
    assert [round(float(side)) for side in pages[0].mediabox[2:]] == [595, 842]
    text = " ".join(page.extract_text() for page in pages)
    for part in ("robot.mcap", "Facts", "Drift", "Parameters of the map", "30, 10."):
        assert part in text
    assert sum(len(page.images) for page in pages) >= 2, "the map and the camera's picture"


def test_the_command_writes_a_page_that_needs_nothing_else(tmp_path: Path) -> None:
    log, out = tmp_path / "robot.mcap", tmp_path / "report.html"
    log.write_bytes(recording())
    done = CliRunner().invoke(app, ["report", str(log), "-o", str(out), "--resolution", "0.1"])
    assert done.exit_code == 0, done.output
    text = _Page(out.read_text("utf-8")).texts
    assert text[text.index("resolution") + 1] == "0.1 m"
    assert text[text.index("log_odds_miss") + 1] == "−0.4"
    as_pdf = tmp_path / "report.pdf"
    assert CliRunner().invoke(app, ["report", str(log), "-o", str(as_pdf), "--resolution", "0.1"]).exit_code == 0
    check_pdf(as_pdf.read_bytes())
    refused = CliRunner().invoke(app, ["report", str(log), "-o", str(tmp_path / "none" / "report.html")])
    assert refused.exit_code == 2
    assert "No such file or directory" in refused.output


def test_the_page_s_report_has_the_notes_and_its_own_policy(tmp_path: Path) -> None:
    with running(settings_for(tmp_path)) as service:
        log_id = str(service.http.put("/api/logs", params={"name": "robot.mcap"}, content=recording()).json()["id"])
        assert once_read(service.http, log_id)["state"] == "ready"
        session = service.begin(kind="log", log=log_id, playing=False)
        until(lambda: service.http.get(f"/api/sessions/{session}/contents").status_code == 200)
        note = {"text": "The door <b>sticks</b>", "x": 1.0, "y": 0.5, "at_s": 1.0, "scan": 10}
        assert service.http.post(f"/api/sessions/{session}/notes", json=note).status_code in (200, 201)
        corners = [[0.5, -1.0], [1.5, -1.0], [1.5, 1.0]]
        area = {"text": "wet floor", "outline": corners}
        assert service.http.post(f"/api/sessions/{session}/notes", json=area).status_code == 201
        answer = service.http.get(f"/api/sessions/{session}/report")
        assert answer.headers["content-type"].startswith("text/html")
        assert "default-src 'none'" in answer.headers["content-security-policy"]
        text = check(answer.text)
        as_pdf = service.http.get(f"/api/sessions/{session}/report.pdf")
        assert as_pdf.headers["content-type"] == "application/pdf"
        check_pdf(as_pdf.content)
        assert "The door <b>sticks</b> " in "".join(text)
        assert "at 0:01.000, at x 1.00 m, y 0.50 m" in text
        of_notes = text[text.index("Notes") : text.index("Parameters of the map")]
        # Of the triangle: the mean of its corners, and half 1 m × 2 m.
        assert "at x 1.17 m, y -0.33 m, 1.00 m²" in of_notes
        drawn = re.findall(r'<polygon points="([^"]+)"', answer.text)
        (path,) = re.findall(r'<polyline[^>]* stroke="([^"]+)"', answer.text)
        assert f'stroke="{path}"' not in re.findall(r"<polygon[^>]*>", answer.text)[0]
        (outline,) = ([[float(part) for part in corner.split(",")] for corner in one.split()] for one in drawn)
        marks = re.findall(r'<circle cx="([^"]+)" cy="([^"]+)"', answer.text)
        at = [[float(x), float(y)] for x, y in marks[-2:]]  # of both notes, 0.05 m a pixel, y down
        assert [outline[1][0] - outline[0][0], outline[2][1] - outline[1][1]] == [20.0, -40.0]
        assert [round(20 * (corners[0][axis] - xy), 1) for axis, xy in enumerate((1.0, 0.5))] == [
            round(outline[0][0] - at[0][0], 1), round(at[0][1] - outline[0][1], 1),
        ]  # fmt: skip
        # The command says the same of the notes that the page wrote.
        geojson = service.http.get(f"/api/sessions/{session}/notes.geojson")
        assert geojson.status_code == 200
    log, notes, out = (tmp_path / name for name in ("robot.mcap", "notes.geojson", "report.html"))
    log.write_bytes(recording())
    notes.write_bytes(geojson.content)
    done = CliRunner().invoke(app, ["report", str(log), "-o", str(out), "--notes", str(notes), "--slam"])
    assert done.exit_code == 0, done.output
    written = _Page(out.read_text("utf-8"))
    assert written.texts[written.texts.index("Notes") : written.texts.index("Parameters of the map")] == of_notes
    assert [kind.partition(";")[0] for kind in written.addresses] == 2 * ["data:image/png"] + ["data:image/jpeg"]
    assert {"Before the correction", "After the correction"} <= set(written.texts)
    assert [name for name in written.texts if name in ("tf/odom", "slam")] == ["tf/odom", "slam"]


def test_notes_that_are_none_are_refused(tmp_path: Path) -> None:
    log, notes = tmp_path / "robot.mcap", tmp_path / "notes.geojson"
    log.write_bytes(recording())
    point = {"type": "Point", "coordinates": [1.0]}
    for wrong in ("{}", "no JSON", json.dumps(_collection(point)), json.dumps(_collection(None))):
        notes.write_text(wrong)
        done = CliRunner().invoke(app, ["report", str(log), "-o", str(tmp_path / "r.html"), "--notes", str(notes)])
        assert done.exit_code == 2, wrong
        assert "notes.geojson" in done.output
    assert not (tmp_path / "r.html").exists()


def _collection(geometry: Mapping[str, object] | None) -> dict[str, object]:
    feature = {"type": "Feature", "geometry": geometry, "properties": {"text": "a"}}
    return {"type": "FeatureCollection", "features": [feature]}
