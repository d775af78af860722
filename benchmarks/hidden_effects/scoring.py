"""Compare diagnoses with the hidden effects by the acceptance rules.

`rod_inertia`, which every robot has and the base model lumps, does not count. A hidden effect is *named* by a finding
of this effect, or by a finding that is confusable with it in a group of at most four effects.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.hidden_effects.cases import HiddenCase
from benchmarks.hidden_effects.strengths import errors, interval_coverage

_MANDATORY = "rod_inertia"
_EXTRAPOLATION_TEXT = "outside of the"
"""Words of the warning by `ident.diagnosis.document.warnings`."""
_LARGEST_GROUP = 4
_EXTRA_VARIABLES = 1
"""Number of wrong variables that may be named in addition to all right ones."""
REACHED = 1.10
"""Largest ratio of held-out error to noise floor at which the noise floor counts as reached."""


@dataclass(frozen=True)
class NamedEffect:
    """An effect in the findings of a diagnosis."""

    effect: str
    group: tuple[str, ...]
    """The effect and those that it is confusable with."""
    joints: tuple[int, ...]

    def names(self, effect: str) -> bool:
        """Whether the finding names `effect`."""
        return effect in self.group and (len(self.group) <= _LARGEST_GROUP or effect == self.effect)


@dataclass(frozen=True)
class ScoredCase:
    """Score of one case."""

    case: HiddenCase
    truth: tuple[dict[str, Any], ...]
    """The hidden effects."""
    verdict: str
    findings: tuple[NamedEffect, ...]
    """Findings without the mandatory effect."""
    variables: tuple[str, ...]
    """Variables that the unknown structure depends on, according to the diagnosis."""
    over_floor: float
    """Ratio of the held-out error of the last model to the noise floor, over all joints."""
    errors: Mapping[str, float]
    """Relative error of the strength of each effect in the last model."""
    covered: tuple[bool, ...]
    """Whether the 95 % interval of each strength contains the true value."""
    extrapolates: bool
    """Whether a warning says that the model fails where the held-out motion leaves the training range."""
    seconds: float
    problem: str | None = None
    """The error, if the diagnosis failed."""

    @property
    def first(self) -> str:
        """Effect of the first finding; the verdict if there is none."""
        return self.findings[0].effect if self.findings else self.verdict

    @property
    def named_count(self) -> int:
        """Number of hidden effects that are named, each by a different finding."""
        return _count_named(self.findings, [effect["name"] for effect in self.truth])

    def is_hidden(self, finding: NamedEffect) -> bool:
        """Whether an effect of the group of a `finding` is hidden."""
        return any(finding.names(effect["name"]) for effect in self.truth)

    @property
    def extra(self) -> int:
        """Number of findings that name no hidden effect."""
        return len(self.findings) - self.named_count

    @property
    def right(self) -> bool:
        """Whether the diagnosis is right by the acceptance rules."""
        if self.problem:
            return False
        if self.case.kind == "nothing":
            return not self.findings and self.verdict == "adequate"
        if self.case.kind in ("single", "added"):
            return bool(self.findings) and self.findings[0].names(self.truth[0]["name"])
        if self.case.kind == "pair":
            return self.named_count == len(self.truth) and self.extra <= 1
        return self.verdict == "unknown-structure" and self.right_variables

    @property
    def right_variables(self) -> bool:
        """Whether all variables of the hidden effect are named, and at most one wrong variable."""
        truth_variables, variables = set(self.truth[0]["depends_on"]), set(self.variables)
        return truth_variables <= variables and len(variables - truth_variables) <= _EXTRA_VARIABLES

    @property
    def right_joints(self) -> bool:
        """Whether the findings of hidden effects have the right joints."""
        by_name = {finding.effect: finding.joints for finding in self.findings}
        return all(
            tuple(effect["joints"]) == by_name[effect["name"]] for effect in self.truth if effect["name"] in by_name
        )


def _count_named(findings: Sequence[NamedEffect], effects: Sequence[str]) -> int:
    """Largest number of `effects` that are named, each by a different finding."""
    if not effects:
        return 0
    first, rest = effects[0], effects[1:]
    counts = [
        1 + _count_named([candidate for candidate in findings if candidate is not finding], rest)
        for finding in findings
        if finding.names(first)
    ]
    return max([_count_named(findings, rest), *counts])


def judge(case: HiddenCase, truth: Mapping[str, Any], line: Mapping[str, Any]) -> ScoredCase:
    """Compare a stored line of `diagnosing` with the sealed truth."""
    hidden = tuple(truth["effects"])
    if "error" in line:
        return ScoredCase(case, hidden, "error", (), (), math.inf, {}, (), False, line["seconds"], line["error"])
    document = line["document"]
    findings = tuple(
        NamedEffect(entry["effect"], (entry["effect"], *entry["confusable_with"]), tuple(entry["joints"]))
        for entry in document["findings"]
        if entry["effect"] != _MANDATORY
    )
    last = document["steps"][-1]
    values = {name: entry["value"] for name, entry in last["parameters"].items()}
    return ScoredCase(
        case=case,
        truth=hidden,
        verdict=document["verdict"],
        findings=findings,
        variables=tuple(document["remaining"]["depends_on"]),
        over_floor=_over_floor(last["held_out_rms"], document["noise_rms"]),
        errors=errors(hidden, values),
        covered=interval_coverage(hidden, last["parameters"]),
        extrapolates=any(_EXTRAPOLATION_TEXT in warning for warning in document.get("warnings", ())),
        seconds=line["seconds"],
    )


def _over_floor(error: Sequence[float], floor: Sequence[float]) -> float:
    return _norm(error) / _norm(floor)


def _norm(values: Sequence[float]) -> float:
    return math.sqrt(sum(value**2 for value in values))
