"""Arrays of two recordings, tables or files, compared by their names."""

from collections.abc import Mapping

import numpy as np


def assert_same(found: object, expected: object, *names: str) -> None:
    """Assert that these arrays are equal, gap for gap; each object is a mapping, or has them as attributes."""
    for name in names:
        first, second = (
            each[name] if isinstance(each, Mapping) else getattr(each, name) for each in (found, expected)
        )
        np.testing.assert_array_equal(first, second, err_msg=name)
