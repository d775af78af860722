"""Print a designed motion as tables or as JSON."""

from typing import Any

import numpy as np
from rich.console import Console

from ident.design.designs import DesignResult
from ident.design.quality import Quality
from ident.output.console.printing import print_table
from ident.output.tables import ResultTable

SCHEMA = 1


def show(outcome: DesignResult, console: Console) -> None:
    """Print condition number, expected standard errors and use of the limits."""
    before = {outcome.against or "": outcome.before} if outcome.before else {}
    motions = {**before, outcome.name: outcome.after}
    table = _discriminability if outcome.after.discriminability else _standard_errors
    print_table(console, table(outcome, motions))
    print_table(console, _limits(outcome, motions))


def _discriminability(outcome: DesignResult, motions: dict[str, Quality]) -> ResultTable:
    rows = []
    for effect in outcome.after.discriminability or ():
        shares = [quality.discriminability[effect] for quality in motions.values() if quality.discriminability]
        # Two significant digits and no exponent: a share may be far above one.
        rows.append((effect, *(f"{100 * x:.2g} %" if x < 0.99 else f"{100 * x:,.0f} %" for x in shares)))
    return ResultTable(
        ("", *motions),
        rows,
        f"Relative to what the model alone does not absorb on {outcome.against}; the smallest value of all joints. "
        "The new motion is evaluated together with the recorded ones.",
        title="Torque of each effect that no other effect can imitate",
    )


def _standard_errors(outcome: DesignResult, motions: dict[str, Quality]) -> ResultTable:
    rows = [("condition number", "", *(f"{quality.condition:.3g}" for quality in motions.values()))]
    for i, parameter in enumerate(outcome.parameters):
        errors = [quality.std[i] for quality in motions.values()]
        cells = [f"{std:.2g}" if np.isfinite(std) else "not excited" for std in errors]
        rows.append((parameter.name, parameter.unit, *cells))
    return ResultTable(
        ("", "unit", *motions),
        rows,
        f"For {outcome.seconds:.3g} s with torque noise of {outcome.noise:g} RMS; proportional to the noise and to "
        "1 / √time.",
        words=(0, 1),
        title=f"Expected standard errors, {outcome.criterion.upper()}-optimal",
        sections=(0,),
    )


def _limits(outcome: DesignResult, motions: dict[str, Quality]) -> ResultTable:
    rows = [
        (
            limit,
            *(
                f"{100 * quality.usage[limit]:.0f} %" if limit in quality.usage else ""
                for quality in motions.values()
            ),
        )
        for limit in outcome.after.usage
    ]
    return ResultTable(("", *motions), rows, title="Used share of each limit")


def as_json(outcome: DesignResult) -> dict[str, Any]:
    """Return the document that `ident design --json` prints."""
    return {
        "schema": SCHEMA,
        "trajectory": outcome.name,
        "criterion": outcome.criterion,
        "seed": outcome.seed,
        "noise": outcome.noise,
        "seconds": outcome.seconds,
        "against": outcome.against,
        "before": outcome.before and _quality_as_json(outcome, outcome.before),
        "after": _quality_as_json(outcome, outcome.after),
    }


def _quality_as_json(outcome: DesignResult, quality: Quality) -> dict[str, Any]:
    errors = zip(outcome.parameters, quality.std, strict=True)
    return {
        "condition_number": quality.condition if np.isfinite(quality.condition) else None,
        "standard_errors": {p.name: float(std) if np.isfinite(std) else None for p, std in errors},
        "discrimination": quality.discriminability,
        "limits": quality.usage,
    }
