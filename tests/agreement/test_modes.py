"""The kernels with index checks, and as plain Python: runs of the table in separate processes."""

from pathlib import Path

import pytest

from tests.agreement.modes import run_table


@pytest.mark.timeout(1800)
@pytest.mark.parametrize(
    ("mode", "examples"),
    [
        pytest.param("bounds", 60, id="bounds", marks=pytest.mark.long),  # compiles all kernels again
        pytest.param("plain", 25, id="plain", marks=pytest.mark.long),
        pytest.param("plain", 2, id="plain, few"),
    ],
)
def test_table_holds(mode: str, examples: int, tmp_path: Path) -> None:
    status, text = run_table(mode, examples, tmp_path)
    assert status == 0, text
