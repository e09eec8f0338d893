"""The page of a report: one HTML file with its pictures in it, which prints on A4."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from datetime import UTC, datetime
from html import escape

from mapper.diagnosis.events.event import clock_time
from server.library.annotations.areas import area_of
from server.report.content import PlacedNote, Report, ReportMap

PATH, EVENT, NOTE = "#08705f", "#a63e08", "#6b3fa0"  #: colours of drawings on a map
BARS_M = (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500)  #: lengths of a scale bar
STYLE = """
@page { size: A4; margin: 14mm; }
:root { color-scheme: light; font: 11pt/1.4 "Source Sans 3", system-ui, sans-serif; }
body { margin: 0 auto; max-width: 182mm; padding: 6mm 4mm; color: #1c1b19; background: #fff; }
h1 { font-size: 18pt; margin: 0; } h2 { font-size: 13pt; margin: 7mm 0 2mm; border-bottom: 1px solid #c9c3b2; break-after: avoid; }
p { margin: 0 0 1.5mm; overflow-wrap: anywhere; } .quiet { color: #55524a; } .number { font-variant-numeric: tabular-nums; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .5mm 5mm; margin: 0; } dt { color: #55524a; } dd { margin: 0; overflow-wrap: anywhere; }
ol, ul { margin: 0; padding-left: 6mm; } li { margin: 0 0 1.5mm; break-inside: avoid; }
.maps { display: grid; gap: 4mm; grid-template-columns: repeat(auto-fit, minmax(78mm, 1fr)); }
figure { margin: 0; break-inside: avoid; } figcaption { margin-top: 1mm; }
figure svg, figure img { display: block; width: 100%; max-height: 95mm; box-sizing: border-box; border: 1px solid #c9c3b2; background: #e5e0cf; }
figure img { width: auto; max-width: 100%; max-height: 75mm; }
table { border-collapse: collapse; width: 100%; font-size: 9.5pt; } td, th { padding: .5mm 2mm; text-align: left; border-bottom: 1px solid #e5e0cf; vertical-align: top; }
tr { break-inside: avoid; } .parameters { columns: 2; column-gap: 8mm; font-size: 9.5pt; break-inside: avoid; } .parameters div { display: flex; justify-content: space-between; gap: 3mm; break-inside: avoid; }
.parameters .changed { font-weight: 600; }
header { display: flex; justify-content: space-between; align-items: start; gap: 4mm; }
@media screen and (max-width: 90mm) { .parameters { columns: 1; } .maps { grid-template-columns: 1fr; } }
@media print { body { padding: 0; max-width: none; } * { print-color-adjust: exact; } }
"""  # noqa: E501 - one line for each group of rules
#: Kinds of events in words.
KINDS = {"pushed": "Pushed", "slipped": "Slipped", "lifted": "Lifted", "clock": "Clock set", "gap": "Nothing recorded"}


def report_page(report: Report) -> str:
    """Return the report as HTML."""
    maps = report.maps
    titles = ["Map"] if len(maps) == 1 else ["Before the correction", "After the correction"]
    parts = [
        (
            f"<header><div><h1>{escape(report.title)}</h1><p class=quiet>Report of "
            f"{report.made:%Y-%m-%d %H:%M} UTC{_recorded(report)}</p></div></header>"
        ),
        f"<h2>Facts</h2><dl>{''.join(_term(name, value) for name, value in report.facts)}</dl>",
        f"<h2>Events</h2>{_events(report)}",
        f"<h2>Findings</h2>{_findings(report)}",
        (
            f"<h2>{'Map' if len(maps) == 1 else 'Maps'}</h2><div class=maps>"
            f"{''.join(_map(map_, title, report.notes) for map_, title in zip(maps, titles, strict=True))}</div>"
        ),
        _drift(maps),
        _picture(report),
        f"<h2>Notes</h2>{_notes(report)}" if report.notes else "",
        (
            "<h2>Parameters of the map</h2><p class=quiet>Those in bold differ from the default values.</p>"
            f"<div class=parameters>{''.join(_parameter(report, *parameter) for parameter in report.parameters)}</div>"
        ),
        f"<h2>Versions</h2><dl>{''.join(_term(name, value) for name, value in report.versions)}</dl>",
    ]
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>Report: {escape(report.title)}</title><style>{STYLE}</style></head><body><main>{''.join(parts)}</main>"
        "</body></html>"
    )


def _recorded(report: Report) -> str:
    if report.start_s is None:
        return ""
    return f" on a log recorded {datetime.fromtimestamp(report.start_s, UTC):%Y-%m-%d %H:%M:%S} UTC"


def _term(name: str, value: str) -> str:
    return f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>"


def _parameter(report: Report, name: str, value: str) -> str:
    changed = " class=changed" if name in report.changed else ""
    shown = f"−{value[1:]}" if value.startswith("-") else value
    return f"<div{changed}><span>{escape(name)}</span><span class=number>{escape(shown)}</span></div>"


def _events(report: Report) -> str:
    if not report.events:
        return "<p>None: no push, slip, lift, step of the clock or gap was found.</p>"
    rows = []
    for event in report.events:
        at = "" if event.utc is None else event.utc.replace("T", " ").replace("Z", " UTC")
        utc = f" <span class=quiet>({escape(at)})</span>" if at else ""
        side = f" {event.direction}" if event.direction and event.kind != "slipped" else ""  # of its wheels
        distance = "" if event.distance_m is None else f" {event.distance_m:.2f} m{side}"
        step = f" {event.step_s:+.2f} s" if event.step_s else ""
        lasted = f" for {event.until_s - event.seconds:.2f} s" if event.kind == "gap" else ""
        rows.append(
            f"<li><b>{KINDS.get(event.kind, escape(event.kind))}{distance}{step}{lasted}</b> at "
            f"<span class=number>{escape(event.time)}</span>{utc}<p>{escape(event.sentence)}</p></li>"
        )
    return f"<ol>{''.join(rows)}</ol><p class=quiet>The numbers are those on the map.</p>"


def _findings(report: Report) -> str:
    if not report.findings:
        return "<p>None.</p>"
    return "<ul>{}</ul>".format(
        "".join(
            f"<li><b>{'Possibly: ' if finding.possible else ''}{escape(finding.sentence)}</b> "
            f"<span class=quiet>({100 * finding.stated_sure:.0f} % sure"
            f"{', ' + escape(finding.sensor) if finding.sensor else ''})</span><p>{escape(finding.advice)}</p></li>"
            for finding in report.findings
        )
    )


def _map(drawn: ReportMap, title: str, notes: Sequence[PlacedNote]) -> str:
    (width, height), (metres, _) = drawn.size_px, drawn.size_m
    scale = width / metres
    unit = max(width, height) / 100.0  # of the drawings on it

    def place(x: float, y: float) -> tuple[float, float]:
        return (x - drawn.low_xy[0]) * scale, height - (y - drawn.low_xy[1]) * scale

    def points(corners: Sequence[tuple[float, float]]) -> str:
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in (place(x, y) for x, y in corners))

    areas = [
        f'<polygon points="{points(note.outline)}" fill="{NOTE}" fill-opacity="0.2" stroke="{NOTE}" '
        f'stroke-width="{0.5 * unit:.2f}"/>'
        for note in notes
        if note.outline is not None
    ]
    marks = [_mark(str(n + 1), *place(x, y), unit, EVENT) for n, (x, y) in enumerate(drawn.events_xy)]
    placed = [note.xy for note in notes]
    marks += [_mark(chr(ord("A") + n), *place(*xy), unit, NOTE) for n, xy in enumerate(placed[:26]) if xy is not None]
    path = f'<polyline points="{points(drawn.path_xy)}" fill="none" stroke="{PATH}" stroke-width="{0.3 * unit:.2f}"/>'
    length = max((bar for bar in BARS_M if bar <= metres / 4.0), default=BARS_M[0])
    bar = (
        f'<path d="M{2 * unit:.1f} {height + 3 * unit:.1f}h{length * scale:.1f}" stroke="#1c1b19" '
        f'stroke-width="{0.6 * unit:.2f}"/><text x="{3 * unit + length * scale:.1f}" y="{height + 4 * unit:.1f}" '
        f'font-size="{3 * unit:.1f}" fill="#1c1b19">{length:g} m</text>'
    )
    return (
        f'<figure><svg viewBox="0 0 {width} {height + 6 * unit:.1f}" role="img" aria-label="{escape(title)}: the map '
        f'along {escape(drawn.trajectory)}"><image width="{width}" height="{height}" style="image-rendering:pixelated" '
        f'href="data:image/png;base64,{b64encode(drawn.png).decode()}"/>{path}{"".join(areas)}{"".join(marks)}{bar}</svg>'
        f"<figcaption><b>{escape(title)}</b>, along {escape(drawn.trajectory)}</figcaption></figure>"
    )


def _mark(text: str, x: float, y: float, unit: float, colour: str) -> str:
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{2 * unit:.1f}" fill="{colour}" stroke="#fff" '
        f'stroke-width="{0.4 * unit:.2f}"/><text x="{x:.1f}" y="{y + unit:.1f}" font-size="{2.8 * unit:.1f}" '
        f'fill="#fff" text-anchor="middle">{text}</text>'
    )


def _drift(maps: Sequence[ReportMap]) -> str:
    rows = "".join(
        f"<tr><th>{escape(row.trajectory)}</th><td>{_metres(row.figures.drift_m)}</td>"
        f"<td>{_share(row.figures.contradicted)}</td><td>{row.figures.sharpness:.3f}</td></tr>"
        for row in maps
    )
    return (
        "<h2>Drift</h2><table><thead><tr><th>Poses</th><th>Walls against their copies of another time</th>"
        "<th>Readings that another time contradicts</th><th>Sharpness of walls, 0 to 1</th></tr></thead>"
        f"<tbody>{rows}</tbody></table>"
    )


def _metres(value: float | None) -> str:
    return "not measured: too little was seen twice" if value is None else f"{value:.2f} m"


def _share(value: float | None) -> str:
    return "–" if value is None else f"{100.0 * value:.1f} %"


def _picture(report: Report) -> str:
    photo = report.picture
    if photo is None:
        return ""
    return (
        f'<h2>Camera</h2><figure><img alt="Picture of {escape(photo.topic)}" '
        f'src="data:{escape(photo.media_type)};base64,{b64encode(photo.data).decode()}">'
        f"<figcaption>{escape(photo.topic)} at <span class=number>{clock_time(photo.seconds)}</span>"
        "</figcaption></figure>"
    )


def _notes(report: Report) -> str:
    rows = []
    for n, note in enumerate(report.notes):
        where = [
            "" if note.seconds is None else f"at {clock_time(note.seconds)}",
            "" if note.xy is None else f"at x {note.xy[0]:.2f} m, y {note.xy[1]:.2f} m",
            "" if note.outline is None else f"{abs(area_of(note.outline)):.2f} m²",
        ]
        letter = f"<b>{chr(ord('A') + n)}</b> " if note.xy is not None and n < 26 else ""
        rows.append(
            f"<li>{letter}{escape(note.text)} <span class=quiet>{', '.join(part for part in where if part)}</span></li>"
        )
    return f"<ul>{''.join(rows)}</ul>"
