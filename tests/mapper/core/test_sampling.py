"""Samples of rows: as many as wanted, each once, from all residues of the row number."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.sampling import sample_rows


@pytest.mark.parametrize(("count", "most"), [(0, 5), (5, 5), (5, 9)])
def test_all_rows_are_taken_where_there_are_few(count: int, most: int) -> None:
    assert sample_rows(count, most).tolist() == list(range(count))


@pytest.mark.parametrize(("count", "most"), [(6, 5), (64_000, 1000), (64_000, 40_000)])
def test_a_sample_has_rows_of_every_residue_once_and_is_the_same_again(count: int, most: int) -> None:
    some = sample_rows(count, most)
    assert len(some) == most
    assert (np.diff(some) > 0).all()
    assert 0 <= some[0] <= some[-1] < count
    assert some.tolist() == sample_rows(count, most).tolist()
    if count >= 64_000:
        of_residue = np.bincount(some % 16, minlength=16)
        np.testing.assert_allclose(of_residue, most / 16, atol=5 * np.sqrt(most / 16))  # five standard deviations
