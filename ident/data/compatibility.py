"""Checks that recordings can be used together: different data, the same rig."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from ident.data.samples import drive_signal, holds_torque, is_relative
from recordings.errors import BadInput
from recordings.recording import Recording
from recordings.urdf import Payload

_GAIN = frozenset(f"torque.{name}" for name in ("gain", "per_ampere", "gain_source", "gain_uncertainty"))
"""Properties that tell the torque of one recording alone, and may differ where they are known."""


def check_no_overlap(recordings: Sequence[Recording]) -> None:
    """Check that no recording is another one, or its beginning.

    Data counted twice make intervals too narrow and a validation worthless.

    Raises:
        BadInput: two recordings begin with the same data.
    """
    for first, second in combinations(recordings, 2):
        n = min(len(first.time), len(second.time))
        pairs = ((first.position, second.position), (drive_signal(first), drive_signal(second)))
        if all(np.array_equal(a[:n], b[:n], equal_nan=True) for a, b in pairs):
            raise BadInput(f"{second.path} and {first.path} begin with the same data; give different recordings")


def of_one_set_up(recording: Recording, payload: Payload | None) -> Recording:
    """Return `recording` as of a rig with this `payload`, with what its own has beyond that."""
    own = recording.rig.payload
    if own == payload:
        return recording
    loads = [(sign * load.known_mass, load.place) for sign, load in ((1, own), (-1, payload)) if load]
    return replace(recording, rig=recording.rig.model_copy(update={"payload": payload}), beyond=tuple(loads))


def reference_payload(recordings: Sequence[Recording]) -> Payload | None:
    """Return the payload that the parameters of a fit to `recordings` include: the first known one, or none.

    Raises:
        BadInput: all are unknown.
    """
    for recording in recordings:
        if not is_unknown(recording):
            return recording.rig.payload
    raise BadInput(
        'a recording without payload or with a known one expected, only payload.mass = "unknown" found; give one, or '
        "remove payload from the rig file: the parameters then include it"
    )


def is_unknown(recording: Recording) -> bool:
    """Whether the rig of `recording` declares a payload of unknown mass."""
    return recording.rig.payload is not None and recording.rig.payload.mass == "unknown"


def refuse_unknown_payload(recordings: Sequence[Recording]) -> None:
    """Check that all payloads are known.

    Raises:
        BadInput: one is unknown.
    """
    for recording in filter(is_unknown, recordings):
        raise BadInput(
            f'{recording.path.name}: a payload of known mass expected, "unknown" found; write it into the rig file: '
            "`ident fit` finds it together with another set-up"
        )


def check_same_rig(recordings: Sequence[Recording], *, own_gains: bool = True) -> None:
    """Check that torque and motion mean the same in all `recordings`; wiring, limits and rate may differ.

    own_gains: whether each recording may have its own gains of the torque, where all of them are known.

    Raises:
        BadInput: a physical property of the rig, or the measured quantity, differs.
    """
    first, *others = recordings
    known = not any(map(is_relative, recordings))
    for recording in others:
        expected, actual = _physical_properties(first), _physical_properties(recording)
        if different := first_difference(expected, actual, own_gains=own_gains and known):
            to_do = remedy(different, "fit them separately") if own_gains else "give those of one rig"
            raise BadInput(
                f"recordings of the same rig expected: {different} is {expected[different]} in {first.path.name}, "
                f"{actual[different]} in {recording.path.name}; {to_do}"
            )


def first_difference(expected: Mapping[str, Any], actual: Mapping[str, Any], *, own_gains: bool) -> str | None:
    """Return the first property of a rig that is not as `expected`, or None.

    own_gains: whether each of the two may have its own gains of the torque.
    """
    names = (name for name in expected if not (own_gains and name in _GAIN))
    return next((name for name in names if expected[name] != actual[name]), None)


def remedy(different: str, usual: str) -> str:
    """Return what to do about a `different` property of a rig: the `usual`, or make its gains known."""
    if different not in _GAIN:
        return usual
    return f"{usual}, or calibrate gains that are only assumed (`ident calibrate-gain`)"


def _physical_properties(recording: Recording) -> dict[str, Any]:
    rig = recording.rig
    sections = {"geometry": rig.geometry.model_dump(), "torque": rig.torque.model_dump()}
    values = {f"{section}.{key}": value for section, content in sections.items() for key, value in content.items()}
    axes = ", ".join(f"{axis.type}{' with gravity' if axis.gravity else ''}" for axis in rig.axes)
    measured = "effort" if holds_torque(recording) else "voltage"
    return {"mechanism": rig.mechanism, "axes": axes, "what was measured": measured, **values, **rig.properties}
