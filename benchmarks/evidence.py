"""`python -m benchmarks.evidence FOLDER [--cases N]`: whether rejected effects have the evidence that `--only` gives.

FOLDER: recordings of `benchmarks.hidden_effects`. Every effect that is refuted or not confirmed is added to the last
model of a diagnosis, which is fitted again from its file, and judged: the record has to be that of `rejected`; where
screening decided, its gain must not exceed the bound. The first effect of each case goes the whole way of
`--model LAST --only EFFECT`.
"""

import random
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import click
import numpy as np

from ident.basics.threads import compute_alone
from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose_prepared, prepare_inputs
from ident.diagnosis.document.result import DiagnosisResult
from ident.diagnosis.document.verdict import to_document
from ident.diagnosis.judge.judge import Evidence, judge
from ident.diagnosis.search.candidates import added_term
from ident.diagnosis.search.search import Search
from ident.dynamics.effects.library import library

_TOLERANCE = 0.01
"""Absolute difference of shares, and relative one of t: the last model is fitted again."""


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, exists=True))
@click.option("--cases", "count", default=40, show_default=True, help="Number of cases, drawn at random.")
@click.option("--seed", default=1, show_default=True, help="What they are drawn from.")
@click.option("--jobs", default=2, show_default=True, help="Cases at the same time.")
def main(folder: Path, count: int, seed: int, jobs: int) -> None:
    """Compare the evidence of rejected effects with that of the same effects when they are asked for."""
    cases = sorted(path.parent for path in folder.glob("*/train.mcap"))
    drawn = random.Random(seed).sample(cases, min(count, len(cases)))
    tried, different = 0, 0
    with ProcessPoolExecutor(jobs, get_context("spawn"), compute_alone) as pool:
        for number, (case, found) in enumerate(zip(drawn, pool.map(differences, drawn), strict=True), start=1):
            tried, different = tried + len(found), different + sum(map(bool, found.values()))
            for effect, reason in found.items():
                if reason:
                    click.echo(f"{case.name}: {effect}: {reason}")
            click.echo(f"{number} {case.name}: {different} of {tried} differ so far", err=True)
    click.echo(f"seed {seed}: {tried - different} of {tried} rejected effects have the evidence that --only gives")


def differences(case: Path) -> dict[str, str | None]:
    """Every effect that is refuted or not confirmed, with what differs in its evidence, or None."""
    effects = library()
    inputs = prepare_inputs([case / "train.mcap"], [case / "validate.mcap"], effects, DiagnosisOptions())
    diagnosis = diagnose_prepared(inputs, effects, DiagnosisOptions())
    result = DiagnosisResult(to_document(diagnosis), diagnosis, DiagnosisOptions())
    last = result.model.file

    search = Search(inputs.split, inputs.effects.observable, lambda text: None)
    start, _ = search.start(*inputs.initial_model(effects, last))

    def asked_for(effect: str) -> Evidence:
        asked = to_document(diagnose_prepared(inputs, effects, DiagnosisOptions(only=(effect,)), initial_model=last))
        return next(finding.evidence for finding in asked.findings if finding.effect == effect)

    def judged(effect: str) -> Evidence:
        after = search.add(start, effect)
        index = added_term(start, after)
        return judge(search.fits.without_effect(after, index), after, index).evidence

    stated = {
        entry.effect: entry.evidence
        for entry in result.document.rejected
        if entry.status in ("refuted", "not-confirmed") and entry.evidence
    }
    ways = dict.fromkeys(stated, judged) | dict.fromkeys(list(stated)[:1], asked_for)
    return {effect: _difference(evidence, ways[effect](effect)) for effect, evidence in stated.items()}


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
