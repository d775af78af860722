"""What a diagnosis says of each effect of the library: found, likely, or rejected, with the reason."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import (
    EvidenceEntry,
    FindingEntry,
    FindingStatus,
    RejectedEntry,
    joint_numbers,
)
from ident.diagnosis.judge.evidence import RejectionStatus
from ident.diagnosis.search.selection import Finding


def merge_repeated(findings: Sequence[Finding]) -> list[Finding]:
    """Merge the findings of the same effect: several lines of a spectrum become one finding.

    The finding with the largest improvement is kept, with the joints of all of them.
    """
    merged: dict[str, Finding] = {}
    for finding in findings:
        present = merged.setdefault(finding.term.name, finding)
        joints = tuple(sorted({*finding.term.joints, *present.term.joints}))
        strongest = max(finding, present, key=lambda item: item.improvement.share)
        merged[finding.term.name] = replace(strongest, term=replace(strongest.term, joints=joints))
    return list(merged.values())


def found_effects(diagnosis: Diagnosis) -> list[FindingEntry]:
    """The effects of the last model, in the order in which they were added."""
    return [_found(diagnosis, finding) for finding in merge_repeated(diagnosis.selection.findings)]


def _found(diagnosis: Diagnosis, finding: Finding) -> FindingEntry:
    status: FindingStatus = "asked-for" if diagnosis.forced else "supported"
    if diagnosis.forced and not finding.judgement.accepted:
        status = "not-supported"
    in_model = finding.term.name in diagnosis.selection.steps[0].model.names
    share, (low, high) = finding.improvement.share, finding.improvement.interval
    if added := not in_model and len(diagnosis.selection.steps) > 1:
        share, (low, high) = _part(diagnosis, finding)
    reasons = [
        f"It takes {share:.0%} ({low:.0%} to {high:.0%}) of the held-out mean square above the noise floor that the "
        f"{'first model' if added else 'model without it'} leaves."
    ]
    if finding.compared > 1:
        reasons.append(f"The interval allows for the choice among {finding.compared} models.")
    if finding.alternatives:
        reasons.append(f"In its place, {' or '.join(finding.alternatives)} would explain these data as well.")
    if status == "not-supported":
        evidence = EvidenceEntry.of(finding.judgement.evidence).in_words
        reasons = [f"It was requested, but held-out data do not confirm it: {evidence}."]
    where = (
        "the whole robot" if finding.term.effect.whole_robot else joint_numbers([j + 1 for j in finding.term.joints])
    )
    return FindingEntry.of(
        finding,
        " ".join((f"On {where}.", *reasons)),
        status=status,
        in_model=in_model,
        share=share if added else None,
    )


def _part(diagnosis: Diagnosis, finding: Finding) -> tuple[float, tuple[float, float]]:
    """Part of a finding in the fall of the held-out excess from the first model to the last, and its interval.

    The fall is divided in proportion to what leaving out each effect alone would add to the mean square.
    """
    steps, first = diagnosis.selection.steps, diagnosis.selection.steps[0].model
    added = [each for each in diagnosis.selection.findings if each.term.name not in first.names]
    own, total = (
        sum(max(each.improvement.reduction, 0.0) for each in effects)
        for effects in ([each for each in added if each.term.name == finding.term.name], added)
    )
    fall = steps[-1].model.improvement_over(first, compared=finding.compared)
    part = own / total if total else 0.0
    return part * fall.share, (part * fall.interval[0], part * fall.interval[1])


def likely_effects(diagnosis: Diagnosis) -> Iterator[FindingEntry]:
    """The effects for which the evidence speaks, but which too few rows were held out to confirm."""
    for finding in diagnosis.selection.likely:
        evidence = finding.judgement.evidence
        yield FindingEntry.of(
            finding,
            f"It would take {evidence.gain:.0%} of the held-out mean square above the noise floor, but these data "
            f"would confirm a gain of this size with a probability of {evidence.power or 0.0:.0%} only. Record a "
            "longer motion.",
            status="likely",
        )


def rejected_effects(diagnosis: Diagnosis, named: set[str]) -> tuple[RejectedEntry, ...]:
    """Every effect of the library that is not among the `named` ones, with the reason that weighs most."""
    selection, effects = diagnosis.selection, diagnosis.effects
    mechanism = diagnosis.split.recordings[0].recording.rig.mechanism
    entries = {
        name: RejectedEntry(
            effect=name,
            status=rejection.status,
            evidence=EvidenceEntry.of(rejection.evidence) if rejection.evidence else None,
            why=rejection.why,
        )
        for name, rejection in selection.rejected.items()
    }
    contained = {name: finding.term.name for finding in selection.findings for name in finding.term.effect.contains}
    others = [name for name, effect in diagnosis.library.items() if mechanism not in effect.mechanisms]
    reasons: dict[RejectionStatus, Mapping[str, str]] = {
        "absorbed": {name: f"It is part of {whole}, which was added." for name, whole in contained.items()},
        "not-tested": effects.untested,
        "not-observable": {
            **effects.unobservable,
            **dict.fromkeys(others, f"It does not occur on a {mechanism} rig."),
        },
    }
    for status, why in reasons.items():
        entries |= {name: RejectedEntry(effect=name, status=status, why=why[name]) for name in why}
    return tuple(entries[name] for name in diagnosis.library if name in entries and name not in named)
