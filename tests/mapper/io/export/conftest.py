"""A log that the tests of this folder export."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mapper.sensors.scan import ScanLog


@pytest.fixture
def log(office_log: ScanLog) -> ScanLog:
    return replace(office_log, mount=(0.2, -0.1, 0.3), upside_down=True)
