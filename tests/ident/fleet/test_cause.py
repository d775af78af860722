"""Which recordings are diagnosed together, and what is said if they cannot be, or if no effect of the library fits;
`test_fleet` names a real cause."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.fleet.cause import RECORDINGS, cause, chosen_nights
from ident.fleet.discoveries import Event
from ident.fleet.series import Nights, Series
from ident.fleet.settings import FleetSettings
from recordings.recording import Floats, Recording
from tests.ident.fleet.conftest import events_of, rows_of, series_of, step

NIGHTS, SINCE = 20, 12
OTHER = (11, 12, 13)
"""Nights with another motion."""


@pytest.fixture
def event_and_series() -> tuple[Event, Nights, list[Series]]:
    """A step of one robot, with another motion before and after it."""
    motion = [[4.0, 0.9 if night in OTHER else 0.5] for night in range(NIGHTS)]
    (nights,), series = series_of(rows_of("r1", {"c_c1": step(NIGHTS, SINCE)}, motion=motion))
    (event,) = events_of(series)
    return event, nights, series


def test_sudden_event_has_the_nights_beside_it_with_motions_of_both_sides(
    event_and_series: tuple[Event, Nights, list[Series]],
) -> None:
    before, after = chosen_nights(*event_and_series[:2])
    assert len(before) == RECORDINGS
    assert before[-1] < SINCE
    assert after[0] >= SINCE
    assert len(after) == RECORDINGS
    motion = event_and_series[1].motion
    assert set(motion[after]) <= set(motion[before]) | set(motion[: before[0]])


def test_growing_event_has_the_last_nights(event_and_series: tuple[Event, Nights, list[Series]]) -> None:
    event = event_and_series[0]
    growing = replace(event.changes[0], change=replace(event.change, growing=True))
    _, after = chosen_nights(replace(event, changes=(growing,)), event_and_series[1])
    assert after.tolist() == list(range(NIGHTS - RECORDINGS, NIGHTS))


def test_recordings_that_are_gone_leave_the_event_unknown(
    event_and_series: tuple[Event, Nights, list[Series]],
) -> None:
    result = cause(*event_and_series, FleetSettings())
    assert (result.verdict, result.effect, result.joints) == ("unknown-structure", None, (1,))
    assert "cannot be diagnosed together" in result.why


SHARE = 0.03
"""RMS of an outside effect relative to that of the torque."""


def bearing_load(velocity: Floats, acceleration: Floats, time: Floats) -> Floats:
    """Dry friction that grows with the acceleration."""
    return np.abs(acceleration) * np.sign(velocity)


def creeping_zero(velocity: Floats, acceleration: Floats, time: Floats) -> Floats:
    """An offset that comes slowly during each run."""
    return 1 - np.exp(-2 * time / time[-1])


def with_outside_effect(recording: Recording, law: Callable[..., Floats]) -> Recording:
    """The `recording` with an effect on its second joint that no library has."""
    gain, joint = np.array(recording.rig.torque.gain), 1
    velocity = np.gradient(recording.position[:, joint], recording.time)
    effect = law(velocity, np.gradient(velocity, recording.time), recording.time)
    torque = gain * recording.voltage * np.abs(recording.voltage)
    torque[:, joint] += SHARE * np.std(torque[:, joint]) / np.std(effect) * effect
    return replace(recording, voltage=np.sign(torque) * np.sqrt(np.abs(torque) / gain))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "variables"), [(bearing_load, {"acceleration", "velocity"}), (creeping_zero, {"time"})]
)
def test_outside_effect_is_unknown_and_says_on_what_it_depends(
    tmp_path: Path,
    make: Callable[..., Recording],
    write: Callable[[Recording], Path],
    law: Callable[..., Floats],
    variables: set[str],
) -> None:
    rows = rows_of("r1", {"c_c2": step(NIGHTS, SINCE)})
    (nights,), series = series_of([{**row, "path": str(tmp_path / Path(row["path"]).name)} for row in rows])
    (event,) = events_of(series)
    for night in np.concatenate(chosen_nights(event, nights)).tolist():
        path = Path(nights.paths[night])
        recording = make("fig5a", cycles=1, rate=250.0, noise=0.01, seed=night, path=path)
        write(with_outside_effect(recording, law) if night >= SINCE else recording)
    result = cause(event, nights, series, FleetSettings())
    assert (result.verdict, result.effect, result.confusable_with, result.joints) == (
        "unknown-structure",
        None,
        (),
        (2,),
    )
    assert set(result.depends_on) == variables
