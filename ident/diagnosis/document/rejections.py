"""Reasons why effects of the library are not among the findings."""

from collections.abc import Iterator

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import RejectedEntry
from ident.diagnosis.ripple.ripple import EFFECT

_CHANCE_LEVEL = 0.01
"""Share of the loss that an effect may explain by chance."""
_MIN_ABSORBED = 0.05
"""An effect counts as absorbed if it explained more than this share of the first loss, and less than half of its
first share of the final loss."""


def rejected_effects(diagnosis: Diagnosis) -> Iterator[RejectedEntry]:
    """Every effect of the library that is no finding, with the reason."""
    selection = diagnosis.selection
    present = {finding.term.name for finding in selection.findings} | ({EFFECT} if diagnosis.ripple.lines else set())
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
            yield RejectedEntry(effect=name, status=rejection.status, why=rejection.why)
