"""Cases in the plant of `tests.foreign`, imported from CSV files."""

from pathlib import Path
from typing import Any

from benchmarks.hidden_effects.cases import Case
from tests.foreign.pairs import Setting, make


def record(case: Case, folder: Path) -> dict[str, Any]:
    """As `simulated.record`."""
    setting = Setting(case.robot, case.volts, case.bits, case.rate, case.reports_command)
    return make(folder, case.effects, case.sizes, case.seed, setting)
