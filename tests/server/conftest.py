"""A running service for the tests that send requests to one."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.server.service import Service, running, settings_for


@pytest.fixture(scope="module")
def service_of_module(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with room for a module's tests."""
    folder = tmp_path_factory.mktemp("service")
    with running(settings_for(folder, max_sessions=200, max_sessions_per_visitor=200)) as service:
        yield service


@pytest.fixture
def service(service_of_module: Service) -> Iterator[Service]:
    """The module's service; sessions that a test begins end with it, so that they do not slow down the next one."""
    yield service_of_module
    service_of_module.end_sessions()
