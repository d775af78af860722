"""Data frames of pandas, which is loaded when one is asked for."""

from collections.abc import Mapping
from typing import Any

from recordings.errors import BadInput


def data_frame(columns: Mapping[str, Any], index: Any = None) -> Any:
    """Make a pandas.DataFrame of columns by name.

    Raises:
        BadInput: pandas is not installed.
    """
    try:
        import pandas
    except ImportError:
        raise BadInput(
            "data frames need pandas, and it is not there; pip install 'delta-workbench[pandas]'"
        ) from None
    return pandas.DataFrame(dict(columns), index=index)
