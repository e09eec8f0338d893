"""The results of a fleet's logs: as a page, one file that needs no server, and as lines."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from html import escape
from itertools import starmap
from pathlib import Path

from mapper.core.atomic_file import atomic_write
from server.fleet.run import Fleet, Result
from server.library.processing.fleet.fleet_job import FleetFinding, MapFacts

PAGE = "index.html"
REFRESH_S = 3  #: interval at which the page reloads while logs are being mapped
STYLE = """
:root { color-scheme: light dark; font: 16px/1.4 system-ui, sans-serif; }
body { margin: 0 auto; max-width: 96rem; padding: 1rem; }
h1 { font-size: 1.4rem; margin: 0 0 .25rem; } h2 { font-size: 1.1rem; margin: 1.5rem 0 .5rem; }
progress { width: 100%; height: 1rem; }
ol.wall { display: grid; gap: .75rem; grid-template-columns: repeat(auto-fill, minmax(13rem, 1fr)); list-style: none; padding: 0; }
ol.wall li { border: 1px solid #8886; border-radius: .4rem; overflow: hidden; }
ol.wall > li > a { display: block; background: #fbfaf6; height: 10rem; }
ol.wall img { width: 100%; height: 100%; object-fit: contain; image-rendering: pixelated; }
ol.wall .text { padding: .4rem .6rem; font-size: .875rem; overflow-wrap: anywhere; }
ol.wall p, ol.wall ul { margin: 0; } ol.wall summary { cursor: pointer; min-height: 24px; } ol.wall ul { padding-left: 1.1rem; }
.finder { display: flex; flex-wrap: wrap; gap: .75rem; align-items: center; margin: .5rem 0; }
.finder :is(input, select) { font: inherit; min-height: 2rem; }
ul.failed { padding-left: 1.1rem; } ul.failed li { margin: .3rem 0; overflow-wrap: anywhere; } code { font-size: .85em; opacity: .8; }
"""  # noqa: E501 - one line for each rule
BY_NAME = "name"
#: The orders other than by name: in words, and the value of a map to sort by, the greatest first.
ORDERS: Mapping[str, tuple[str, Callable[[MapFacts], float | None]]] = {
    "drift": ("most drift first", lambda facts: facts.drift_m),
    "findings": ("most findings first", lambda facts: len(facts.findings)),
    "sharpness": ("least sharp first", lambda facts: None if facts.contrast is None else -facts.contrast),
    "scans": ("most scans first", lambda facts: facts.scans),
    "size": ("largest map first", lambda facts: math.prod(_size_m(facts))),
}
DRIFTS_M = (0.1, 0.3, 1.0)  #: lower limits of drift for which the page can filter, metres
#: Sorts and filters the cards as stated in the address, which is kept when the page reloads.
SCRIPT = r"""
const wall = document.querySelector(".wall"), cards = [...wall.children];
const fields = [...document.querySelectorAll(".finder :is(input, select)")];
const asked = new URLSearchParams(location.hash.slice(1));
for (const field of fields) field.value = asked.get(field.id) ?? field.value;
const [words, drift, order] = fields;
function show() {
  const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
  const key = (card) => Number(card.dataset[order.value] ?? -Infinity);
  for (const card of cards) {
    const text = card.textContent.toLowerCase();
    card.hidden = Number(card.dataset.drift ?? 0) < Number(drift.value) || !wanted.every((word) => text.includes(word));
  }
  wall.append(...(order.value === "name" ? cards : [...cards].sort((a, b) => (key(a) < key(b)) - (key(a) > key(b)))));
  document.getElementById("found").textContent = cards.filter((card) => !card.hidden).length + " found";
  history.replaceState(null, "", "#" + new URLSearchParams(fields.map((field) => [field.id, field.value])));
}
for (const field of fields) field.addEventListener("input", show);
show();
"""
#: Not while the user types or chooses. A page whose address has a fragment is not reloaded by ``refresh``.
RELOAD = f"""
setInterval(() => document.activeElement.closest(".finder") || location.reload(), {1000 * REFRESH_S});
"""


def ordered(results: Sequence[Result], order: str = BY_NAME) -> list[tuple[Result, MapFacts]]:
    """Return the results with a map, by name or in one of :data:`ORDERS`; maps without that value come last."""
    mapped = sorted(
        ((result, result.facts) for result in results if result.facts is not None), key=lambda entry: entry[0].log
    )
    if order != BY_NAME:
        key = ORDERS[order][1]
        mapped.sort(key=lambda entry: -math.inf if (value := key(entry[1])) is None else value, reverse=True)
    return mapped


def line_of(result: Result, facts: MapFacts) -> str:
    """Return the result of a log in one line."""
    first, *others = _sentences(facts)
    return f"{result.log}: {_measures(facts)}, {_run(facts)}. {first}{f' And {len(others)} more.' if others else ''}"


def write_page(fleet: Fleet, *, running: bool) -> None:
    """Write the page with all results so far. Raises :class:`OSError`."""
    with atomic_write(fleet.folder / PAGE) as file:
        file.write(page(list(fleet.results.values()), len(fleet.logs), running=running).encode())


def page(results: Sequence[Result], total: int, *, running: bool) -> str:
    """Return the page, which reloads itself while the fleet is ``running``."""
    cards = ordered(results)
    failed = sorted((result for result in results if result.failed), key=lambda failure: failure.log)
    state = "running" if running else "ended"
    rows = "".join(
        f"<li><b>{escape(_name(failure))}</b>: {escape(failure.message)} <code>{escape(failure.code)}</code></li>"
        for failure in failed
    )
    failures = f'<h2>Failed: {len(failed)}</h2><ul class="failed">{rows}</ul>' if failed else ""
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width"><title>{len(results)} of {total} logs</title>'
        f"<style>{STYLE}</style></head><body><main><h1>{len(results)} of {total} logs, {state}</h1>"
        f'<progress value="{len(results)}" max="{max(total, 1)}" aria-label="Logs done"></progress>{failures}'
        f'<h2>Maps: {len(cards)}</h2>{_finder()}<ol class="wall">{"".join(starmap(_card, cards))}</ol></main>'
        f"<script>{SCRIPT}{RELOAD if running else ''}</script></body></html>"
    )


def _finder() -> str:
    drifts = [("0", "any drift"), *((f"{least:g}", f"drift of {least:g} m or more") for least in DRIFTS_M)]
    orders = [(BY_NAME, "by name"), *((name, words) for name, (words, _) in ORDERS.items())]
    choices = "".join(
        f'<select id="{name.lower()}" aria-label="{name}">'
        f"{''.join(f'<option value={value}>{words}</option>' for value, words in options)}</select>"
        for name, options in (("Drift", drifts), ("Order", orders))
    )
    return (
        '<search class="finder"><input id="words" type="search" aria-label="Search logs" '
        f'placeholder="Search name, finding">{choices}<span id="found" role="status"></span></search>'
    )


def _name(result: Result) -> str:
    return Path(result.log).name


def _sentences(facts: MapFacts) -> list[str]:
    return [_sentence(finding) for finding in facts.findings] or ["No findings."]


def _sentence(finding: FleetFinding) -> str:
    return f"Possibly: {finding.sentence}" if finding.possible else finding.sentence


def _measures(facts: MapFacts) -> str:
    drift = "Drift not measured" if facts.drift_m is None else f"Drift {facts.drift_m:.2f} m"
    return drift if facts.contrast is None else f"{drift}, sharpness {facts.contrast:.2f}"


def _run(facts: MapFacts) -> str:
    width, height = (max(1, round(side)) for side in _size_m(facts))
    return f"{facts.scans:,} scans, {width} × {height} m"


def _size_m(facts: MapFacts) -> tuple[float, float]:
    return facts.cols * facts.resolution, facts.rows * facts.resolution


def _card(result: Result, facts: MapFacts) -> str:
    first, *others = map(escape, _sentences(facts))
    values = {name: key(facts) for name, (_, key) in ORDERS.items()}
    data = "".join(f' data-{name}="{value:g}"' for name, value in values.items() if value is not None)
    file = f"maps/{result.key}.png"
    image = f'<a href="{file}"><img src="{file}" loading="lazy" alt="Map of {escape(_name(result))}"></a>'
    picture = image if facts.picture else ""
    items = "".join(f"<li>{other}</li>" for other in others)
    title = f"{len(others)} more finding{'' if len(others) == 1 else 's'}"
    more = f"<details><summary>{title}</summary><ul>{items}</ul></details>" if others else ""
    return (
        f'<li{data}>{picture}<div class="text"><p><a href="{escape(Path(result.log).as_uri())}">'
        f"{escape(_name(result))}</a></p>"
        f"<p>{_measures(facts)}</p><p>{_run(facts)}</p><p>{first}</p>{more}</div></li>"
    )
