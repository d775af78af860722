"""Cases of the plant in `tests.foreign`, imported from CSV files."""

from pathlib import Path
from typing import Any

from benchmarks.hidden_effects.cases import HiddenCase
from recordings.errors import BadInput
from tests.foreign.pairs import Setting, make

_ROBOTS = 8
"""Number of robots drawn at most, until the effects can have their sizes. A tuned case has one."""


def setting_of(case: HiddenCase) -> Setting:
    """Robot, sensors and signals of a `case`."""
    return Setting(
        case.robot,
        case.volts,
        case.bits,
        case.rate,
        case.reports_command,
        case.repeats,
        case.signal,
        case.signal_bits,
    )


def record(case: HiddenCase, folder: Path) -> dict[str, Any]:
    """Write train.mcap and validate.mcap into `folder`; return the truth.

    Raises:
        BadInput: the effects cannot have their sizes on any of the robots drawn.
    """
    setting = setting_of(case)
    last = case.seed + (_ROBOTS - 1 if case.part != "tuned" else 0)
    for seed in range(case.seed, last):
        try:
            return make(folder, case.effects, case.sizes, seed, setting)
        except BadInput:
            continue
    return make(folder, case.effects, case.sizes, last, setting)
