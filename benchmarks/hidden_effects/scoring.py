"""What was said against what was hidden, by the rules of the acceptance.

`rod_inertia`, which the base model lumps and every robot has, does not count. A hidden effect is *named* by a finding
of its name, or by one that may be confused with it, if that group has four names at most.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.hidden_effects.cases import Case
from benchmarks.hidden_effects.strengths import errors, inside

_ALWAYS_TRUE = "rod_inertia"
_BEYOND = "outside of the"
"""In the caution about a motion that goes beyond the training."""
_LARGEST_GROUP = 4
_EXTRA_VARIABLES = 1
"""How many variables too many may be named along with all the right ones."""
REACHED = 1.10
"""Held-out error over noise floor."""


@dataclass(frozen=True)
class Finding:
    """An effect that was said to be there."""

    effect: str
    group: tuple[str, ...]
    """Itself and what it may be confused with."""
    joints: tuple[int, ...]

    def names(self, effect: str) -> bool:
        """Whether it may be this effect."""
        return effect in self.group and (len(self.group) <= _LARGEST_GROUP or effect == self.effect)


@dataclass(frozen=True)
class Judgement:
    """Of one case."""

    case: Case
    truth: tuple[dict[str, Any], ...]
    """The hidden effects."""
    verdict: str
    findings: tuple[Finding, ...]
    """Without those that are always true."""
    variables: tuple[str, ...]
    """On which the unknown structure is said to depend."""
    over_floor: float
    """Held-out error of the last model over the noise floor, over all joints."""
    errors: Mapping[str, float]
    """Relative, of the strength of each effect that was named exactly."""
    inside: tuple[bool, ...]
    """Of those strengths that plant and `ident` call the same: whether the 95 % interval holds the truth."""
    beyond: bool
    """Whether it is said that the held-out motion goes beyond the training, and that the model fails there."""
    seconds: float
    problem: str | None = None
    """An error in place of a diagnosis."""

    @property
    def first(self) -> str:
        """What was said first, or the verdict."""
        return self.findings[0].effect if self.findings else self.verdict

    @property
    def found(self) -> int:
        """How many of the hidden effects are named, each by a finding of its own."""
        return _named(self.findings, [effect["name"] for effect in self.truth])

    @property
    def extra(self) -> int:
        """How many findings name nothing that is there."""
        return len(self.findings) - self.found

    @property
    def right(self) -> bool:
        """As the acceptance has it."""
        if self.problem:
            return False
        if self.case.kind == "nothing":
            return self.verdict == "adequate"
        if self.case.kind == "single":
            return bool(self.findings) and self.findings[0].names(self.truth[0]["name"])
        if self.case.kind == "pair":
            return self.found == len(self.truth) and self.extra <= 1
        return self.verdict == "unknown-structure" and self.right_variables

    @property
    def right_variables(self) -> bool:
        """Whether all that the hidden effect depends on is named, and hardly anything else."""
        true, said = set(self.truth[0]["depends_on"]), set(self.variables)
        return true <= said and len(said - true) <= _EXTRA_VARIABLES

    @property
    def right_joints(self) -> bool:
        """Whether the hidden effects that are named exactly are said to be on the right joints."""
        by_name = {finding.effect: finding.joints for finding in self.findings}
        return all(
            tuple(effect["joints"]) == by_name[effect["name"]] for effect in self.truth if effect["name"] in by_name
        )


def _named(findings: Sequence[Finding], effects: Sequence[str]) -> int:
    """How many of the effects are named, each by a finding of its own."""
    if not effects:
        return 0
    first, rest = effects[0], effects[1:]
    ways = [
        1 + _named([other for other in findings if other is not finding], rest)
        for finding in findings
        if finding.names(first)
    ]
    return max([_named(findings, rest), *ways])


def judge(case: Case, truth: Mapping[str, Any], line: Mapping[str, Any]) -> Judgement:
    """Compare the line that a diagnosis left with the sealed truth."""
    hidden = tuple(truth["effects"])
    if "error" in line:
        return Judgement(case, hidden, "error", (), (), math.inf, {}, (), False, line["seconds"], line["error"])
    document = line["document"]
    findings = tuple(
        Finding(entry["effect"], (entry["effect"], *entry["confusable_with"]), tuple(entry["joints"]))
        for entry in document["findings"]
        if entry["effect"] != _ALWAYS_TRUE
    )
    last = document["rungs"][-1]
    values = {name: entry["value"] for name, entry in last["parameters"].items()}
    return Judgement(
        case=case,
        truth=hidden,
        verdict=document["verdict"],
        findings=findings,
        variables=tuple(document["remaining"]["depends_on"]),
        over_floor=_norm(last["validate_rms"]) / _norm(document["noise_rms"]),
        errors=errors(hidden, values),
        inside=inside(hidden, last["parameters"]),
        beyond=any(_BEYOND in caution for caution in document.get("cautions", ())),
        seconds=line["seconds"],
    )


def _norm(values: Sequence[float]) -> float:
    return math.sqrt(sum(value**2 for value in values))
