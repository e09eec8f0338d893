"""What visitors leave behind levels off, whatever happens meanwhile to the database, the disk and the clock."""

from __future__ import annotations

import os

import pytest

from tests.load.soak import soak


@pytest.mark.long
def test_a_soak_ends_with_a_clean_verdict() -> None:
    soak(int(os.environ.get("GRIDBLOOM_SOAK_MIN", "60")))
