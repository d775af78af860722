"""`python -m benchmarks.evidence FOLDER [--cases N]`: whether rejected effects have the evidence that `--only` gives.

FOLDER: recordings of `benchmarks.hidden_effects`. For every effect that is refuted or not confirmed, the last model
of a diagnosis is diagnosed again with `--model LAST --only EFFECT`: the record has to be that of `rejected`; where
screening decided, its gain must not exceed the bound.
"""

import random
from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np

import ident
from ident.diagnosis.judge.evidence import Evidence
from ident.identification.model import Model

_TOLERANCE = 0.01
"""Absolute difference of shares, and relative one of t: the last model is fitted again."""


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, exists=True))
@click.option("--cases", "count", default=40, show_default=True, help="Number of cases, drawn at random.")
@click.option("--seed", default=1, show_default=True, help="What they are drawn from.")
def main(folder: Path, count: int, seed: int) -> None:
    """Compare the evidence of rejected effects with that of the same effects when they are asked for."""
    cases = sorted(path.parent for path in folder.glob("*/train.mcap"))
    tried, different = 0, 0
    for case in random.Random(seed).sample(cases, min(count, len(cases))):
        for effect, reason in differences([case / "train.mcap"], [case / "validate.mcap"]):
            tried += 1
            if reason:
                different += 1
                click.echo(f"{case.name}: {effect}: {reason}")
        click.echo(f"{case.name}: {different} of {tried} differ so far", err=True)
    click.echo(f"seed {seed}: {tried - different} of {tried} rejected effects have the evidence that --only gives")


def differences(train: list[Path], validate: list[Path]) -> Iterator[tuple[str, str | None]]:
    """Every effect that is refuted or not confirmed, with what differs in its evidence, or None."""
    result = ident.diagnose(train, validate=validate)
    last = result.model
    for entry in result.document.rejected:
        if entry.status in ("refuted", "not-confirmed") and entry.evidence:
            yield entry.effect, _difference(entry.evidence, _asked_for(last, train, validate, entry.effect))


def _asked_for(last: Model, train: list[Path], validate: list[Path], effect: str) -> Evidence:
    result = ident.diagnose(train, validate=validate, model=last, only=(effect,))
    return next(finding.evidence for finding in result.document.findings if finding.effect == effect)


def _difference(stated: Evidence, asked: Evidence) -> str | None:
    if stated.decided_by == "screening":
        exceeds = asked.gain > stated.gain + _TOLERANCE
        return f"gain {asked.gain:.3f} exceeds the bound {stated.gain:.3f}" if exceeds else None
    if stated.decided_by != asked.decided_by:
        return f"{stated.decided_by} decided, but with --only {asked.decided_by}"
    for name in ("gain", "gain_ci95", "t", "power"):
        one, other = (np.atleast_1d(getattr(entry, name)) for entry in (stated, asked))
        if not np.allclose(one, other, rtol=_TOLERANCE if name == "t" else 0.0, atol=_TOLERANCE):
            return f"{name} is {one.tolist()}, but with --only {other.tolist()}"
    return None


if __name__ == "__main__":
    main()
