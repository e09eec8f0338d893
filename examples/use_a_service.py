"""Send a log to a service, wait until it was read, print what the doctor finds, and write its map as a picture.

Without an address a service is started for the time of the program.
"""

from __future__ import annotations

import argparse
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mapper.io.export import GrowingMap, write_mcap
from mapper.mapping.integrate import grid_for
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import sample_log
from server.client import Client
from server.serving import listen, make_server
from server.settings import Settings


@contextmanager
def own_service() -> Iterator[str]:
    """Run a service on a free port of this machine, and yield its address."""
    with tempfile.TemporaryDirectory() as folder, listen("127.0.0.1", 0) as socket:
        server = make_server(Settings(data_dir=Path(folder), port=0, log_level="warning"))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [socket]})
        thread.start()
        while thread.is_alive() and not server.started:
            time.sleep(0.01)
        try:
            yield f"http://127.0.0.1:{socket.getsockname()[1]}"
        finally:
            server.should_exit = True
            thread.join()


def simulated_run(path: Path) -> Path:
    """Write a short simulated log, for who has no log at hand."""
    log, config = sample_log(40), MappingConfig()
    with path.open("wb") as file:
        write_mcap(file, log, GrowingMap(grid_for(log, config), config))
    return path


def main(out: Path, log_path: Path | None, url: str) -> None:
    """Write map.png."""
    out.mkdir(parents=True, exist_ok=True)
    with Client(url) as client:
        log = client.wait(client.upload(log_path or simulated_run(out / "run.mcap")))
        print(f"{log.name}: {log.scans} scans of {log.beams} beams over {log.duration_s:.0f} s")
        session = client.seek(client.open(log))
        findings = client.doctor(session)
        print(f"{len(findings)} findings")
        for finding in findings:
            print(f"  {finding.check}: {finding.sentence}")
        grid = client.map(session)
        print(f"{(grid.classify() == 100).sum()} cells are occupied; the map is at {client.link(session)}")
        (out / "map.png").write_bytes(client.picture(session))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", type=Path, nargs="?", help="log of any format that Gridbloom reads")
    parser.add_argument("--url", help="address of a service, with its token if it asks for one")
    parser.add_argument("--out", type=Path, default=Path("out"), help="folder for the files that are written")
    arguments = parser.parse_args()
    if arguments.url:
        main(arguments.out, arguments.log, arguments.url)
    else:
        with own_service() as address:
            main(arguments.out, arguments.log, address)
