"""Cases of the plant in `tests.foreign`, imported from CSV files."""

from pathlib import Path
from typing import Any

from benchmarks.hidden_effects.cases import Case
from tests.foreign.pairs import Setting, make


def record(case: Case, folder: Path) -> dict[str, Any]:
    """Write train.mcap and validate.mcap into `folder`; return the truth."""
    setting = Setting(case.robot, case.volts, case.bits, case.rate, case.reports_command)
    return make(folder, case.effects, case.sizes, case.seed, setting)
