"""Reasons why effects of the library are not among the findings."""

from collections.abc import Iterator, Sequence

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
        elif selection.last_extensions.excluded.get(name) == "collinear":
            reason = "This motion does not show it: other parameters reproduce its torque."
            yield RejectedEntry(effect=name, status="not-tested", why=reason)
        elif name in selection.last_extensions.excluded:
            reason = "It would need an impossible sign."
            yield RejectedEntry(effect=name, status="not-supported", why=reason)
        else:
            yield _not_added(diagnosis, name, sorted(present))


def _not_added(diagnosis: Diagnosis, name: str, present: Sequence[str]) -> RejectedEntry:
    first, last = (
        extensions.loss_reductions.get(name, 0.0)
        for extensions in (diagnosis.selection.first_extensions, diagnosis.selection.last_extensions)
    )
    if diagnosis.forced:
        reason = f"It was not requested. It would explain {last:.1%} of the remaining residual, by screening."
        return RejectedEntry(effect=name, status="not-supported", why=reason)
    refusal = diagnosis.selection.refused.get(name)
    if refusal and last > _CHANCE_LEVEL:
        reason = f"It would explain {last:.1%} of the remaining residual, but {refusal}."
        return RejectedEntry(effect=name, status="not-supported", why=reason)
    if first > _MIN_ABSORBED and last < first / 2:
        others = ", ".join(present)
        reason = f"Alone it would explain {first:.0%} of the first residual, but only {last:.1%} beside {others}."
        return RejectedEntry(effect=name, status="absorbed", why=reason)
    ending = "but the held-out data do not support it" if last > _CHANCE_LEVEL else "hardly more than chance"
    reason = f"It would explain {last:.1%} of the remaining residual, {ending}."
    return RejectedEntry(effect=name, status="not-supported", why=reason, hopeless=last <= _CHANCE_LEVEL)
