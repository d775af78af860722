"""Which effects of the library recordings can show, on which joints, and why not the others."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ident.data.samples import holds_torque
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect
from recordings.recording import Floats

MAX_RARE_SHARE = 0.25
"""A direction is rare below this share of the moving time: its friction is hardly known."""
MIN_TEMPERATURE_CHANGE = 2.0
"""A smaller change of the temperature says nothing about friction [K]: grease loses some percent of it per degree."""


@dataclass(frozen=True, eq=False)
class Observability:
    """The effects of a library, sorted by what recordings can say about them."""

    observable: Mapping[str, Effect]
    """Effects that such recordings can show, restricted to the joints on which these recordings can."""
    unobservable: Mapping[str, str]
    """Effects that such recordings cannot show, with the reason."""
    untested: Mapping[str, str]
    """Effects that are not tested in these recordings, with the reason."""


def observability(split: SplitData, library: Mapping[str, Effect], without: Sequence[str] = ()) -> Observability:
    """Sort the effects of the `library` for the mechanism of the recordings, but for those of other mechanisms.

    without: effects that the user leaves out.
    """
    recording = split.recordings[0].recording
    rig, torque_measured = recording.rig, holds_torque(recording)
    # Range of the temperature of each joint over all training recordings [K]; NaN where it is unknown.
    temperature = np.concatenate([split.recordings[i].temperature for i in split.train_indices])
    warming = np.fmax.reduce(temperature) - np.fmin.reduce(temperature)
    observable: dict[str, Effect] = {}
    unobservable: dict[str, str] = {}
    untested: dict[str, str] = {}
    of_mechanism = {name: effect for name, effect in library.items() if rig.mechanism in effect.mechanisms}
    for name, effect in of_mechanism.items():
        if name in without:
            untested[name] = "Left out by the user."
        elif reason := effect.why_unobservable(rig, torque_measured, bool(np.isfinite(warming).any())):
            unobservable[name] = reason
        else:
            reasons = {
                joint: " ".join(_lacking(split, effect, joint, warming)) for joint in effect.possible_joints(rig)
            }
            joints = tuple(joint for joint, lacking in reasons.items() if not lacking)
            if joints:
                observable[name] = effect if len(joints) == len(reasons) else effect.changed(joints=joints)
            else:
                untested[name] = next(iter(reasons.values()))
    return Observability(observable, unobservable, untested)


def _lacking(split: SplitData, effect: Effect, joint: int, warming: Floats) -> Iterator[str]:
    """Yield what the recordings lack to test `effect` on `joint` (from 0)."""
    if "both directions" in effect.needs and (share := rarer_direction_share(split)[joint]) < MAX_RARE_SHARE:
        yield f"Joint {joint + 1} moves in one of its directions only {share:.0%} of the time; record both equally."
    if "temperature" in effect.needs and not warming[joint] >= MIN_TEMPERATURE_CHANGE:
        known = f"changes by {warming[joint]:.2g} K only" if np.isfinite(warming[joint]) else "was not recorded"
        yield f"The temperature of joint {joint + 1} {known}; record while the machine warms up."


def rarer_direction_share(split: SplitData) -> Floats:
    """(dof,) share of the moving training rows that move in the rarer direction."""
    directions = np.concatenate(
        [
            np.sign(np.where(train, data.motion.velocity, 0.0))
            for data, train in zip(split.recordings, split.train, strict=True)
        ]
    )
    forwards, backwards = (directions > 0).sum(axis=0), (directions < 0).sum(axis=0)
    return np.minimum(forwards, backwards) / np.maximum(forwards + backwards, 1)
