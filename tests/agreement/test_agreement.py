"""Each kernel equals its textbook twin to the last bit on random inputs."""

import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.agreement.table import TABLE, Row

EXAMPLES = int(os.environ.get("GRIDBLOOM_EXAMPLES", "12"))


@pytest.mark.sampled
@pytest.mark.parametrize("row", TABLE, ids=lambda row: row.name)
@given(data=st.data())
@settings(
    max_examples=EXAMPLES, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
def test_kernel_equals_textbook(row: Row, data: st.DataObject) -> None:
    case = data.draw(row.inputs)
    for ours, theirs in zip(row.kernel(case), row.twin(case), strict=True):
        if isinstance(theirs, np.ndarray):
            assert ours.dtype == theirs.dtype
            if row.tolerance and np.issubdtype(theirs.dtype, np.floating):
                np.testing.assert_allclose(ours, theirs, rtol=row.tolerance, atol=row.tolerance)
            else:
                np.testing.assert_array_equal(ours, theirs)
        else:
            assert ours == theirs
