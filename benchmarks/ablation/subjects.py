"""Cases of the ablation: simulated robots, traps and real machines, each with its outcome and a score."""

import signal
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.ablation import variants, watching
from benchmarks.hidden_effects.cases import HiddenCase
from benchmarks.real.data_set import Manifest

if TYPE_CHECKING:  # it imports what is watched
    from tests.foreign.traps import Kind

TODAY = "today"
"""In place of a variant: the diagnosis as it is."""
PATIENCE = 600
"""Longest time for a diagnosis [s]."""
_FAILED = -99
"""Score of a diagnosis that ends in an error."""
_CLAIMS = {"right": 2, "or": 1, "wrong": -1}
"""Points for a claim about a real machine; for any other judgement 0."""


@dataclass(frozen=True)
class VariantOutcome:
    """What a diagnosis said."""

    text: str
    """Verdict, variables and findings with their joints and alternatives."""
    score: int
    """More is better; comparable within one case."""


@dataclass(frozen=True)
class Subject:
    """A case."""

    name: str
    diagnose: Callable[[], VariantOutcome]


def robot(case: HiddenCase, root: Path) -> VariantOutcome:
    """Diagnose a case of `benchmarks.hidden_effects`: 10 points if it is right, 1 less for each name of nothing."""
    from benchmarks.hidden_effects import diagnosing, scoring
    from drivers.simulated.seal import sealed_path, unseal

    line = diagnosing.diagnose(case, root, "")
    if "error" in line:
        return VariantOutcome(f"error {line['error']}", _FAILED)
    judgement = scoring.judge(case, unseal(sealed_path(root / case.name / "train.mcap")), line)
    return VariantOutcome(text_of(line["document"]), 10 * judgement.right - judgement.extra)


def trap(kind: "Kind", seed: int) -> VariantOutcome:
    """Make and diagnose a trap: 2 points if nothing is named, 1 if another name than the false ones is."""
    from benchmarks.hidden_effects import traps

    document = traps.diagnose_trap(kind, seed)
    score = 0 if traps.false_names(document) else 1 if document.findings else 2
    return VariantOutcome(text_of(document.as_json()), score)


def machine(manifest: Manifest, folder: Path) -> VariantOutcome:
    """Import and diagnose the data of a real machine: the sum of the points of all claims."""
    from benchmarks.real import diagnosing

    with tempfile.TemporaryDirectory() as scratch:
        outcome = diagnosing.diagnose(manifest, folder, Path(scratch))
    points = sum(_CLAIMS.get(judgement, 0) for _, judgement in outcome.claims)
    return VariantOutcome(text_of(outcome.document or {}), points)


def text_of(document: Mapping[str, Any]) -> str:
    """Verdict, variables, findings, orders of ripple, what is likely, vibrations and warnings in one line."""
    findings = [
        "|".join([entry["effect"], *entry["confusable_with"]]) + "".join(f" {joint}" for joint in entry["joints"])
        for entry in document["findings"]
    ]
    parameters = document["steps"][-1]["parameters"].items()
    orders = [f"{entry['value']:.3g} per turn" for name, entry in parameters if name.endswith(".N")]
    likely = [f"likely {entry['effect']}" for entry in document["likely"]]
    band = document["above_low_pass"] or {"vibrations": ()}
    counts = f"{len(band['vibrations'])} vibrations, {len(document['warnings'])} warnings"
    verdict = " ".join([document["verdict"], *document["remaining"]["depends_on"]])
    return "; ".join([verdict, *findings, *orders, *likely, counts])


@dataclass(frozen=True)
class Pair:
    """A case, and the variant that diagnoses it."""

    subject: Subject
    variant: str = TODAY

    @property
    def name(self) -> str:
        """Both names."""
        return f"{self.subject.name} {self.variant}"


@dataclass(frozen=True)
class Trial:
    """What came of a pair."""

    case: str
    variant: str
    seconds: float
    """Time of the processor."""
    outcome: VariantOutcome
    near: frozenset[str] = frozenset()
    """Variants that change a comparison; known where the case was watched."""
    used: frozenset[str] = frozenset()
    """Variants of constants that are used otherwise."""


def watch(pair: Pair) -> Trial:
    """Diagnose a case as today and note which variants can change it."""
    watching.install()
    watching.NEAR.clear()
    watching.USED.clear()
    trial = try_(pair)
    used = {key + factor for key in watching.USED for factor in variants.FACTORS}
    return Trial(trial.case, TODAY, trial.seconds, trial.outcome, frozenset(watching.NEAR), frozenset(used))


def try_(pair: Pair) -> Trial:
    """Diagnose a case by a variant."""
    from ident.basics.threads import compute_alone

    compute_alone()
    with nullcontext() if pair.variant == TODAY else variants.applied(pair.variant):
        start = time.process_time()
        try:
            with _alarm():
                outcome = pair.subject.diagnose()
        except Exception as error:  # any error is an outcome; the other pairs continue
            outcome = VariantOutcome(f"error {type(error).__name__}: {error}", _FAILED)
        seconds = time.process_time() - start
    return Trial(pair.subject.name, pair.variant, round(seconds, 2), outcome)


@contextmanager
def _alarm() -> Iterator[None]:
    """Raise TimeoutError in the main thread if the block takes longer than PATIENCE."""
    signal.signal(signal.SIGALRM, _raise)
    signal.alarm(PATIENCE)
    try:
        yield
    finally:
        signal.alarm(0)


def _raise(number: int, frame: object) -> None:
    raise TimeoutError(f"no diagnosis within {PATIENCE} s")
