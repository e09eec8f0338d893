"""The page of a fleet: a wall of pictures of its maps, and the logs that failed, in one file that needs no server."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from itertools import starmap
from pathlib import Path

from mapper.core.atomic_file import atomic_write
from server.fleet.run import Fleet, Result
from server.library.processing.fleet.fleet_job import MapFacts

PAGE = "index.html"
REFRESH_S = 3  #: how often the page loads itself again while logs are being done
STYLE = """
:root { color-scheme: light dark; font: 16px/1.4 system-ui, sans-serif; }
body { margin: 0 auto; max-width: 96rem; padding: 1rem; }
h1 { font-size: 1.4rem; margin: 0 0 .25rem; } h2 { font-size: 1.1rem; margin: 1.5rem 0 .5rem; }
progress { width: 100%; height: 1rem; }
ol.wall { display: grid; gap: .75rem; grid-template-columns: repeat(auto-fill, minmax(13rem, 1fr)); list-style: none; padding: 0; }
ol.wall li { border: 1px solid #8886; border-radius: .4rem; overflow: hidden; }
ol.wall a { display: block; background: #fbfaf6; height: 10rem; }
ol.wall img { width: 100%; height: 100%; object-fit: contain; image-rendering: pixelated; }
ol.wall .text { padding: .4rem .6rem; font-size: .875rem; overflow-wrap: anywhere; }
ol.wall p, ol.wall ul { margin: 0; } ol.wall summary { cursor: pointer; min-height: 24px; } ol.wall ul { padding-left: 1.1rem; }
ul.failed { padding-left: 1.1rem; } ul.failed li { margin: .3rem 0; overflow-wrap: anywhere; } code { font-size: .85em; opacity: .8; }
"""  # noqa: E501 - one line for each rule


def write_page(fleet: Fleet, *, running: bool) -> None:
    """Write the page with all results so far. Raises :class:`OSError`."""
    with atomic_write(fleet.folder / PAGE) as file:
        file.write(page(list(fleet.results.values()), len(fleet.logs), running=running).encode())


def page(results: Sequence[Result], total: int, *, running: bool) -> str:
    """Return the page, which loads itself again while the fleet is ``running``."""
    made = sorted(
        ((result, result.facts) for result in results if result.facts is not None), key=lambda entry: entry[0].log
    )
    failed = sorted((result for result in results if result.failed), key=lambda one: one.log)
    refresh = f'<meta http-equiv="refresh" content="{REFRESH_S}">' if running else ""
    state = "running" if running else "ended"
    rows = "".join(
        f"<li><b>{escape(_name(one))}</b>: {escape(one.message)} <code>{escape(one.code)}</code></li>" for one in failed
    )
    failures = f'<h2>Failed: {len(failed)}</h2><ul class="failed">{rows}</ul>' if failed else ""
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">{refresh}'
        f'<meta name="viewport" content="width=device-width"><title>{len(results)} of {total} logs</title>'
        f"<style>{STYLE}</style></head><body><h1>{len(results)} of {total} logs, {state}</h1>"
        f'<progress value="{len(results)}" max="{max(total, 1)}" aria-label="Logs done"></progress>{failures}'
        f'<h2>Maps: {len(made)}</h2><ol class="wall">{"".join(starmap(_card, made))}</ol></body></html>'
    )


def _name(result: Result) -> str:
    return Path(result.log).name


def _card(result: Result, facts: MapFacts) -> str:
    first, *others = [escape(finding.sentence) for finding in facts.findings] or ["No findings"]
    file = f"maps/{result.key}.png"
    image = f'<a href="{file}"><img src="{file}" loading="lazy" alt="Map of {escape(_name(result))}"></a>'
    picture = image if facts.picture else ""
    said = "".join(f"<li>{other}</li>" for other in others)
    title = f"{len(others)} more finding{'' if len(others) == 1 else 's'}"
    more = f"<details><summary>{title}</summary><ul>{said}</ul></details>" if others else ""
    drifted = "Drift not measured" if facts.drift_m is None else f"Drift {facts.drift_m:.2f} m"
    return (
        f'<li>{picture}<div class="text"><p><b>{escape(_name(result))}</b></p>'
        f"<p>{drifted}, {facts.scans} scans</p><p>{first}</p>{more}</div></li>"
    )
