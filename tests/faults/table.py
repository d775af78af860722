"""Table of the campaign."""

import sys
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from tests.faults.campaign import Outcome


def show(title: str, outcomes: Sequence[Outcome]) -> None:
    """Print one row per fault."""
    table = Table(title=title, box=None)
    for heading in (
        "fault",
        "detected ms",
        "disabled ms",
        "error mrad",
        "samples lost",
        "rows lost",
        "exit",
        "as required",
        "reason",
    ):
        table.add_column(heading, justify="right" if heading.endswith(("ms", "mrad", "lost", "exit")) else "left")
    for o in outcomes:
        error = "-" if o.following_error is None else f"{o.following_error * 1e3:.1f}"
        numbers = (_ms(o.detected), _ms(o.disabled), error, str(o.samples_lost), str(o.rows_lost), str(o.code))
        table.add_row(o.fault, *numbers, "yes" if o.passed else "NO", _reason(o), style=None if o.passed else "red")
    console = Console(width=180, markup=False)
    console.print(table)
    console.print(f"{sum(o.passed for o in outcomes)} of {len(outcomes)} as required")


def tick(outcome: Outcome) -> None:
    """Print the outcome of a fault on stderr."""
    print(f"{'ok ' if outcome.passed else 'NO '} {outcome.fault}: {_reason(outcome)}", file=sys.stderr, flush=True)


def _reason(outcome: Outcome) -> str:
    return outcome.reason if outcome.begun else f"ended before the fault: {outcome.reason}"


def _ms(value: float | None) -> str:
    return "-" if value is None else f"{value:.0f}"
