"""Print a designed motion as tables or as JSON."""

from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from ident.design.designs import DesignResult
from ident.design.quality import Quality

SCHEMA = 1


def show(outcome: DesignResult, console: Console) -> None:
    """Print condition number, expected standard errors and use of the limits."""
    if outcome.after.discriminability:
        console.print(_discriminability(outcome))
    else:
        console.print(_standard_errors(outcome))
    console.print(_limits(outcome))


def _discriminability(outcome: DesignResult) -> Table:
    table = Table(title="Torque of each effect that no other effect can imitate", title_justify="left")
    table.add_column("")
    motions = _motions(outcome)
    for name, _ in motions:
        table.add_column(name, justify="right")
    for effect in outcome.after.discriminability or ():
        shares = [quality.discriminability[effect] for _, quality in motions if quality.discriminability]
        table.add_row(effect, *map(_percent, shares))
    table.caption = (
        f"Relative to what the model alone does not absorb on {outcome.against}; the smallest value of all joints. "
        "The new motion is evaluated together with the recorded ones."
    )
    return table


def _percent(share: float) -> str:
    """Format `share` in percent with two significant digits and no exponent."""
    return f"{100 * share:.2g} %" if share < 0.99 else f"{100 * share:,.0f} %"


def _standard_errors(outcome: DesignResult) -> Table:
    table = Table(title=f"Expected standard errors, {outcome.criterion.upper()}-optimal", title_justify="left")
    table.add_column("")
    table.add_column("unit")
    motions = _motions(outcome)
    for name, _ in motions:
        table.add_column(name, justify="right")
    table.add_row("condition number", "", *(f"{quality.condition:.3g}" for _, quality in motions))
    table.add_section()
    for i, parameter in enumerate(outcome.parameters):
        table.add_row(parameter.name, parameter.unit, *(_format_error(quality.std[i]) for _, quality in motions))
    table.caption = (
        f"For {outcome.seconds:.3g} s with torque noise of {outcome.noise:g} RMS; proportional to the noise and to "
        "1 / √time."
    )
    return table


def _format_error(std: float) -> str:
    return f"{std:.2g}" if np.isfinite(std) else "not excited"


def _limits(outcome: DesignResult) -> Table:
    table = Table(title="Used share of each limit", title_justify="left")
    table.add_column("")
    motions = _motions(outcome)
    for name, _ in motions:
        table.add_column(name, justify="right")
    for limit in outcome.after.usage:
        table.add_row(limit, *(_used_share(quality, limit) for _, quality in motions))
    return table


def _used_share(quality: Quality, limit: str) -> str:
    return f"{100 * quality.usage[limit]:.0f} %" if limit in quality.usage else ""


def _motions(outcome: DesignResult) -> list[tuple[str, Quality]]:
    before = [(outcome.against or "", outcome.before)] if outcome.before else []
    return [*before, (outcome.name, outcome.after)]


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
