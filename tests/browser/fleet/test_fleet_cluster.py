"""The page of the fleet while a Dask cluster maps the logs, of which a worker and the scheduler are killed."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Page, expect

from tests.browser.looking import until
from tests.browser.running import running_server
from tests.server.dask_cluster import DaskCluster, dask_cluster, kill
from tests.server.library.small_logs import carmen


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DaskCluster]:
    with dask_cluster(tmp_path_factory.mktemp("cluster")) as made:
        yield made


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory, cluster: DaskCluster) -> Iterator[str]:
    """A service whose fleet is on the cluster, and its logs."""
    folder = tmp_path_factory.mktemp("logs")
    for count in (20, 21, 22):
        (folder / f"{count}.log").write_bytes(carmen(count))
    options = ("--logs-dir", str(folder), "--fleet-executor", cluster.address)
    with running_server(tmp_path_factory.mktemp("data"), *options) as address:
        yield address


@pytest.mark.long
def test_the_page_tells_of_the_cluster_and_loses_no_log(page: Page, server: str, cluster: DaskCluster) -> None:
    page.goto(f"{server}/fleet.html")
    main = page.get_by_role("main")
    expect(main).to_contain_text("The scheduler of the Dask cluster is not reached")
    page.get_by_role("button", name="Map 3 logs").click()
    expect(main).to_contain_text("Logs that are not mapped yet wait, and go on by themselves.")
    cluster.begin_scheduler()
    first = cluster.begin_worker("first")
    expect(main).to_contain_text("On a Dask cluster with 1 worker, 1 log at once.")
    until("a worker to have a log", lambda: bool(cluster.jobs("first")))
    kill(first)
    expect(main).to_contain_text("The Dask cluster has no workers.")
    cluster.kill_scheduler()
    expect(main).to_contain_text("The scheduler of the Dask cluster is not reached")
    cluster.begin_scheduler()
    cluster.begin_worker("second")
    cluster.begin_worker("third")
    expect(main).to_contain_text("On a Dask cluster with 2 workers, 2 logs at once.")
    expect(main).to_contain_text("3 of 3 logs done")
    expect(main.get_by_role("status").filter(has_text="cluster")).to_have_count(0)
    expect(page.locator(".fleet-card", has_text="21.log")).to_contain_text("21 scans")
    assert cluster.address not in page.content(), "visitors need not know where it is"
