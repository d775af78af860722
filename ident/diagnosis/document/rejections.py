"""Reasons why effects of the library are not among the findings."""

from collections.abc import Iterator

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import EvidenceEntry, RejectedEntry
from ident.diagnosis.ripple.ripple import EFFECT


def rejected_effects(diagnosis: Diagnosis) -> Iterator[RejectedEntry]:
    """Every effect of the library that is no finding, with the reason."""
    selection = diagnosis.selection
    named = (*selection.findings, *selection.likely)
    present = {finding.term.name for finding in named} | ({EFFECT} if diagnosis.ripple.lines else set())
    contained = {name: finding.term.name for finding in selection.findings for name in finding.term.effect.contains}
    mechanism = diagnosis.split.recordings[0].recording.rig.mechanism
    for name, effect in diagnosis.library.items():
        if name in present:
            continue
        if mechanism not in effect.mechanisms:
            yield RejectedEntry(
                effect=name, status="not-observable", why=f"It does not occur on mechanism {mechanism}."
            )
        elif name in diagnosis.effects.unobservable:
            yield RejectedEntry(effect=name, status="not-observable", why=diagnosis.effects.unobservable[name])
        elif name in diagnosis.effects.untested:
            yield RejectedEntry(effect=name, status="not-tested", why=diagnosis.effects.untested[name])
        elif name in contained:
            reason = f"It is part of {contained[name]}, which was added."
            yield RejectedEntry(effect=name, status="absorbed", why=reason)
        elif rejection := selection.rejected.get(name):
            evidence = EvidenceEntry.of(rejection.evidence) if rejection.evidence else None
            yield RejectedEntry(effect=name, status=rejection.status, evidence=evidence, why=rejection.why)
