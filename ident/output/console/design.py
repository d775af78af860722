"""A designed motion on the screen and as JSON."""

from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from ident.design.designs import Outcome
from ident.design.quality import Quality

SCHEMA = 1


def show(outcome: Outcome, console: Console) -> None:
    """Print condition number, expected standard errors and use of the limits."""
    if outcome.after.told_apart:
        console.print(_told_apart(outcome))
    else:
        console.print(_errors(outcome))
    console.print(_limits(outcome))


def _told_apart(outcome: Outcome) -> Table:
    table = Table(title="Torque of each effect that no rival imitates", title_justify="left")
    table.add_column("")
    motions = _motions(outcome)
    for name, _ in motions:
        table.add_column(name, justify="right")
    for effect in outcome.after.told_apart or ():
        shares = [quality.told_apart[effect] for _, quality in motions if quality.told_apart]
        table.add_row(effect, *map(_percent, shares))
    table.caption = (
        f"Over what the model alone leaves of it on {outcome.against}; on the joint where it is least. "
        "The new motion counts together with those that are recorded."
    )
    return table


def _percent(share: float) -> str:
    """Two significant digits, but no exponent, however much an effect does."""
    return f"{100 * share:.2g} %" if share < 0.99 else f"{100 * share:,.0f} %"


def _errors(outcome: Outcome) -> Table:
    table = Table(title=f"Expected standard errors, {outcome.criterion.upper()}-optimal", title_justify="left")
    table.add_column("")
    table.add_column("unit")
    motions = _motions(outcome)
    for name, _ in motions:
        table.add_column(name, justify="right")
    table.add_row("condition number", "", *(f"{quality.condition:.3g}" for _, quality in motions))
    table.add_section()
    for i, parameter in enumerate(outcome.parameters):
        table.add_row(parameter.name, parameter.unit, *(_error(quality.std[i]) for _, quality in motions))
    table.caption = (
        f"For {outcome.seconds:.3g} s with noise of {outcome.noise:g} RMS in the torque; they grow with the noise "
        "and fall with the root of the time."
    )
    return table


def _error(std: float) -> str:
    return f"{std:.2g}" if np.isfinite(std) else "not shown"


def _limits(outcome: Outcome) -> Table:
    table = Table(title="Share of the limits that is used", title_justify="left")
    table.add_column("")
    motions = _motions(outcome)
    for name, _ in motions:
        table.add_column(name, justify="right")
    for limit in outcome.after.usage:
        table.add_row(limit, *(_share(quality, limit) for _, quality in motions))
    return table


def _share(quality: Quality, limit: str) -> str:
    return f"{100 * quality.usage[limit]:.0f} %" if limit in quality.usage else ""


def _motions(outcome: Outcome) -> list[tuple[str, Quality]]:
    before = [(outcome.against or "", outcome.before)] if outcome.before else []
    return [*before, (outcome.name, outcome.after)]


def as_json(outcome: Outcome) -> dict[str, Any]:
    """The document that `ident design --json` prints."""
    return {
        "schema": SCHEMA,
        "trajectory": outcome.name,
        "criterion": outcome.criterion,
        "seed": outcome.seed,
        "noise": outcome.noise,
        "seconds": outcome.seconds,
        "against": outcome.against,
        "before": outcome.before and _quality(outcome, outcome.before),
        "after": _quality(outcome, outcome.after),
    }


def _quality(outcome: Outcome, quality: Quality) -> dict[str, Any]:
    errors = zip(outcome.parameters, quality.std, strict=True)
    return {
        "condition_number": quality.condition if np.isfinite(quality.condition) else None,
        "standard_errors": {p.name: float(std) if np.isfinite(std) else None for p, std in errors},
        "told_apart": quality.told_apart,
        "limits": quality.usage,
    }
