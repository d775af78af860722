"""Compare proposed formulas with the hidden laws."""

import math
import re
from dataclasses import dataclass
from typing import Any

from benchmarks.hidden_effects.cases import HiddenCase
from tests.foreign.beyond_library import quantities

_QUANTITY = re.compile(r"\b(direction|load|qdd|qd|q|t)(\d*)\b")
"""In the columns of a formula."""


@dataclass(frozen=True)
class ScoredFormula:
    """Score of one case."""

    case: HiddenCase
    text: str
    """The columns of the formula; the error if the diagnosis failed; empty if there is none."""
    terms: int
    """0: no formula."""
    right: bool
    """Whether on each of its joints it uses what the hidden law uses there, and nothing else."""
    before: float
    """Held-out error of the model without the formula over that of the right model."""
    after: float
    """With the formula."""
    seconds: float
    """Of the search for a formula."""

    @property
    def law(self) -> str:
        """What is hidden."""
        return self.case.effects[0] if self.case.kind == "outside" else self.case.kind


def score(case: HiddenCase, truth: dict[str, Any], line: dict[str, Any]) -> ScoredFormula:
    """Compare a stored `line` of `diagnosing` with the sealed truth."""
    if "error" in line:
        return ScoredFormula(case, line["error"], 0, False, math.inf, math.inf, math.inf)
    formula, floor = line["formula"], math.hypot(*line["floor"])
    return ScoredFormula(
        case,
        " + ".join(formula["columns"]),
        formula["terms"],
        is_right(formula["columns"], formula["joints"], truth["effects"]),
        math.hypot(*line["before"]) / floor,
        math.hypot(*line["after"]) / floor,
        line["propose_seconds"],
    )


def is_right(columns: list[str], joints: list[int], effects: list[dict[str, Any]]) -> bool:
    """Whether the `columns` use on each of `joints` (from 1) what that of `effects` uses which is in no library."""
    true = {
        joint: set(names)
        for law in effects
        if not law["in_library"]
        for joint, names in quantities(law["name"], law["joints"], law["parameters"]).items()
    }
    return bool(joints) and all(used(columns, joint) == true.get(joint) for joint in joints)


def used(columns: list[str], joint: int) -> set[str]:
    """Quantities that the `columns` use on a `joint` (from 1); those of another joint with its number."""
    found = {match for column in columns for match in _QUANTITY.findall(column)}
    return {name.replace("direction", "qd") + (number if number != str(joint) else "") for name, number in found}
