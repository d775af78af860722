"""How many times longer than on a quiet machine answers may take while simulated time stands still."""

import math
import os

from recordings.errors import BadInput

VARIABLE = "DELTA_WORKBENCH_PATIENCE"
_LARGEST = 100.0


def factor() -> float:
    """What the environment says, 1 where it says nothing.

    Raises:
        BadInput: that is no number from 1 to 100.
    """
    text = os.environ.get(VARIABLE) or "1"
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 1.0 <= number <= _LARGEST:
        raise BadInput(f"{VARIABLE}: a number from 1 to {_LARGEST:g} expected, {text!r} found; correct or unset it")
    return number
