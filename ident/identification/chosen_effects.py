"""Effects that the user chooses by name."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from ident.data.samples import holds_torque
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import Term
from recordings.errors import BadInput, did_you_mean, told
from recordings.recording import Recording


def check_effect_name(name: str, library: Collection[str]) -> None:
    """Check that the `library` has the effect `name`.

    Raises:
        BadInput: it has not; the message names the effect that may be meant.
    """
    if name not in library:
        raise BadInput(
            f"effect: a name of the library expected, '{name}' found;{did_you_mean(name, library)} "
            "`ident effects` lists them"
        )


def mandatory_terms(
    library: Mapping[str, Effect], recording: Recording, without: Sequence[str] = ()
) -> tuple[Term, ...]:
    """The effects of the `library` that every real machine of this kind has, but for those in `without`.

    Raises:
        BadInput: an effect in `without` is no such effect.
    """
    base = [
        name for name, effect in library.items() if effect.mandatory and recording.rig.mechanism in effect.mechanisms
    ]
    for name in without:
        check_effect_name(name, library)
        if name not in base:
            expected = ", ".join(base) or "none, because this mechanism has no such effect,"
            raise BadInput(
                f"{told('--without', 'without')}: an effect of the base model ({expected}) expected, '{name}' found; "
                "leave it out"
            )
    return tuple(Term.on_all_joints(name, library[name], recording.rig) for name in base if name not in without)


def parse_terms(choices: Sequence[str], library: Mapping[str, Effect], recording: Recording) -> tuple[Term, ...]:
    """Convert the effects chosen by the user, NAME (all joints) or NAME:1,3 (some joints), to terms.

    Raises:
        BadInput: the effect does not exist, is named twice or is not observable in such a recording, or one of its
            joints does not exist.
    """
    terms: list[Term] = []
    for choice in choices:
        term = _parse_term(choice, library, recording)
        if any(term.name == previous.name for previous in terms):
            raise BadInput(f"every effect once expected, '{term.name}' found twice; leave one out")
        terms.append(term)
    return tuple(terms)


def _parse_term(choice: str, library: Mapping[str, Effect], recording: Recording) -> Term:
    rig = recording.rig
    name, colon, joints = choice.partition(":")
    check_effect_name(name, library)
    effect = library[name]
    if rig.mechanism not in effect.mechanisms:
        raise BadInput(
            f"effect {name}: mechanism {' or '.join(effect.mechanisms)} expected, {rig.mechanism} found; leave it out"
        )
    temperature_measured = bool(np.isfinite(recording.temperature).any())
    reason = effect.why_unobservable(rig, holds_torque(recording), temperature_measured)
    if reason:
        raise BadInput(f"effect {name} cannot be seen in such a recording: {reason} Leave it out")
    if not colon:
        return Term.on_all_joints(name, effect, rig)
    numbers = _parse_joints(name, joints, rig.dof)
    for joint in numbers:
        if reason := effect.impossible(rig, joint):
            raise BadInput(f"effect {name} cannot be on joint {joint + 1}: {reason} Name other joints")
    return Term(name, effect, numbers)


def _parse_joints(name: str, joints: str, dof: int) -> tuple[int, ...]:
    numbers = joints.split(",")
    if not all(number.isdigit() and 1 <= int(number) <= dof for number in numbers) or len(set(numbers)) < len(
        numbers
    ):
        raise BadInput(f"effect {name}: joints 1 to {dof}, such as {name}:1,2, expected, '{joints}' found")
    return tuple(int(number) - 1 for number in numbers)
