"""Values that no joint has."""

import numpy as np

from recordings.plausible import first_implausible


def test_first_value_that_no_joint_has() -> None:
    values = np.array([[1.0, np.nan], [2.0, -1e7], [1e160, 0.0]])
    assert first_implausible(values, "position") == (1, 1)
    assert first_implausible(values[:, 0], "effort") == (2,)
    assert first_implausible(np.array([np.inf]), "effort") == (0,)
    assert first_implausible(np.array([np.nan, 1e6, -1e6]), "position") is None
