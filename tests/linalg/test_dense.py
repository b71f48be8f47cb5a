"""Eigenpairs of dense pencils."""

import numpy as np
import pytest

import aoimpact as ao
from aoimpact.linalg import dense_modes


@pytest.mark.parametrize("count", [None, 5])
@pytest.mark.parametrize("dofs", [10, 200])
def test_a_mass_that_is_not_positive_is_refused(count: int | None, dofs: int) -> None:
    with pytest.raises(ao.SingularError, match=r"^K"):
        dense_modes(np.eye(dofs), -np.eye(dofs), count)
