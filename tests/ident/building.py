"""Recordings of a bench with independent axes and known torque, through the public path, for tests of later stages.

Everything here takes a fraction of a second, so that properties and coverage can be tested on many recordings.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ident.basics.filters import mean_sign
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.search import Search
from ident.diagnosis.split.observability import observability
from ident.diagnosis.split.split_data import SplitData
from ident.diagnosis.split.train_test_split import split_recordings
from ident.dynamics import mechanisms
from ident.dynamics.effects.base import Additive, Effect, Quantity
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.regression import Regression
from recordings.recording import Floats, Recording
from recordings.rig import Axis, Rig
from tests.made_up import run_of

RATE, PERIOD, CUTOFF = 250.0, 4.0, 30.0
"""SYNCs per second [Hz], duration of a cycle [s], cut-off [Hz]."""
INERTIA, VISCOUS, COULOMB = 0.4, 0.8, 1.5
"""True parameters of every joint."""
HARMONICS = ((1, 1.0), (2, 0.5), (3, 0.3), (5, 0.2))
"""Order and relative amplitude."""
WANDER = (0.2924, 1e-4)
"""Order and amplitude of a slow wander [rad]: cycles of a real machine do not repeat to the last digit, and the
encoder step is estimated from differences of readings."""

Torque = Callable[[Motion], Floats]
"""Additional torque (n, dof) [N m] of a motion, which the mechanism does not have."""
DRAG = 0.3
"""Size of `drag`."""


def drag(motion: Motion) -> Floats:
    """(n, dof) torque of quadratic friction [N m]."""
    torque: Floats = DRAG * motion.velocity * np.abs(motion.velocity)
    return torque


def bench(joints: int = 1) -> Rig:
    """A rig of `joints` independent revolute axes without weight."""
    return Rig(name="bench", mechanism="axes", axes=(Axis(),) * joints)


def parameters(joints: int = 1) -> Floats:
    """(3 * joints,) true parameters, in the order of the mechanism."""
    return np.repeat([INERTIA, VISCOUS, COULOMB], joints)


def motion_of(
    joints: int = 1, cycles: int = 4, size: float = 1.0, shape: int = 0, rate: float = RATE, drift: float = 0.0
) -> Motion:
    """A periodic motion of several harmonics, in which position, velocity and acceleration are hardly correlated.

    size: amplitude of the first harmonic [rad]. shape: number of the motion. drift: additional speed [rad/s].
    """
    time = np.arange(round(cycles * PERIOD * rate)) / rate
    phases = np.random.default_rng([shape, 7]).uniform(0, 2 * np.pi, (joints, len(HARMONICS)))
    position, velocity, acceleration = np.zeros((3, len(time), joints))
    for joint in range(joints):
        waves = [(order, size * share, phase) for (order, share), phase in zip(HARMONICS, phases[joint], strict=True)]
        for order, amplitude, phase in (*waves, (*WANDER, float(joint))):
            omega = 2 * np.pi * order / PERIOD
            angle = omega * time + phase
            position[:, joint] += amplitude * np.sin(angle)
            velocity[:, joint] += amplitude * omega * np.cos(angle)
            acceleration[:, joint] -= amplitude * omega**2 * np.sin(angle)
    position, velocity = position + drift * time[:, None], velocity + drift
    return Motion(position, velocity, acceleration, np.nan_to_num(mean_sign(velocity)))


def record(
    joints: int = 1,
    cycles: int = 4,
    *,
    noise: float = 0.0,
    seed: int = 0,
    extra: Torque | None = None,
    encoder_step: float = 1e-6,
    name: str = "bench",
    temperature: Floats | None = None,
    **motion_options: Any,
) -> Recording:
    """A recording of measured torque: that of the true parameters plus `extra` plus white `noise` [N m].

    encoder_step: positions are rounded to multiples of it [rad].
    temperature: (n, joints) of the drives [degC]; None: not measured.
    """
    motion = motion_of(joints, cycles, **motion_options)
    rig = bench(joints)
    effort = mechanisms.create(rig).regressor(motion) @ parameters(joints)
    if extra is not None:
        effort = effort + extra(motion)
    effort = effort + noise * np.random.default_rng(seed).normal(size=effort.shape)
    n, rate = len(effort), motion_options.get("rate", RATE)
    position = np.round(motion.position / encoder_step) * encoder_step
    run = run_of(trajectory=name, trajectory_digest="", period=PERIOD, cycles=cycles, rate=rate, exit_status=0)
    return Recording(
        path=Path(f"{name}.mcap"),
        rig=rig,
        run=run,
        time=np.arange(n) / rate,
        position=position,
        command=position,
        voltage=np.full_like(effort, np.nan),
        velocity=None,
        effort=effort,
        statusword=np.zeros((n, joints), np.uint16),
        error_code=np.zeros((n, joints), np.uint16),
        repeat=(np.arange(n) // round(PERIOD * rate)).astype(np.int64),
        lateness=np.zeros(n),
        events=(),
        known_digest=name,
        extra={} if temperature is None else {f"temperature_{i + 1}": x for i, x in enumerate(temperature.T)},
    )


def prepared(recording: Recording) -> PreparedRecording:
    """`recording` as diagnosis uses it."""
    return prepare(recording, "parallel", CUTOFF)


def with_noise(exact: PreparedRecording, noise: Floats) -> PreparedRecording:
    """A prepared recording with additional `noise` (n, dof) in the measured torque [N m], before the filter.

    Faster than preparing another recording.
    """
    return replace(exact, torque=exact.torque + exact.condition(noise))


def regression(recording: Recording) -> Regression:
    """Rows of `recording` for a linear fit of the mechanism."""
    return Regression.of_mechanism(prepared(recording))


def split(train: Sequence[Recording], validate: Sequence[Recording] = ()) -> SplitData:
    """Training rows and test rows of recordings."""
    return split_recordings([prepared(x) for x in train], [prepared(x) for x in validate])


def of_size(torque: Torque, share: float, **motion_options: Any) -> Torque:
    """`torque` of one joint, so large that the mechanism cannot absorb a `share` of its own torque (RMS) of it."""
    motion = motion_of(**motion_options)
    regressor = mechanisms.create(bench()).regressor(motion)[:, 0]
    column = torque(motion)[:, 0]
    unexplained = column - regressor @ np.linalg.lstsq(regressor, column, rcond=None)[0]
    scale = share * float(np.std(regressor @ parameters()) / np.std(unexplained))
    return lambda motion: scale * torque(motion)


def search(data: SplitData, effects: Mapping[str, Effect]) -> tuple[Search, tuple[ModelStructure, Floats]]:
    """A search with the `effects`, and where it begins: the mechanism alone, and parameters (K,)."""
    model = structure(data.recordings[0].recording)
    return Search(data, effects, lambda text: None), (model, start(model))


def named(train: Recording, validate: Recording, without: Sequence[str] = ()) -> list[tuple[str, ...]]:
    """The effects that a diagnosis finds, each with those that it could be confused with."""
    data = split([train], [validate])
    selector, begin = search(data, observability(data, library(), without).observable)
    return [(each.term.name, *each.alternatives) for each in selector.select(*begin).findings]


def effect(column: Torque, **options: Any) -> Additive:
    """An effect whose torque is a coefficient times `column` of the motion; with other `options` of effects."""
    return Additive(
        **{
            "sentence": "",
            "symptom": "",
            "causes": "",
            "remedy": "",
            "equation": "",
            "axis": "position",
            "parameters": (Quantity(name="a", unit="{effort}", meaning="size"),),
            "columns": lambda inputs, shapes: column(inputs.motion)[:, :, None],
            **options,
        }
    )


def structure(recording: Recording, *names: str, joints: Sequence[int] | None = None) -> ModelStructure:
    """The mechanism with the effects `names` of the library on `joints` (from 0; None: all)."""
    rig = recording.rig
    result = ModelStructure(mechanisms.create(rig), rig)
    for name in names:
        result = result.with_term(Term(name, library()[name], tuple(range(rig.dof) if joints is None else joints)))
    return result


def start(model: ModelStructure) -> Floats:
    """(K,) zero for linear parameters, the typical size for others."""
    return np.array([0.0 if entry.linear else entry.scale for entry in model.parameters])


def with_wave(order: float, *names: str) -> FittedModel:
    """A model with `names`, cogging among them, of a recording with a wave over the angle of the `order`."""
    recording = record(noise=0.05, extra=lambda motion: 0.5 * np.sin(order * motion.position), seed=3)
    data, model = split([recording]), structure(recording, *names)
    x = start(model)
    x[[entry.name for entry in model.parameters].index("cogging.N")] = order
    return FittedModel(data, data.fit(model, x))


def fitted(data: SplitData, *names: str, joints: Sequence[int] | None = None) -> FittedModel:
    """The mechanism with the effects `names`, fitted to the training rows."""
    model = structure(data.recordings[0].recording, *names, joints=joints)
    return FittedModel(data, data.fit(model, start(model)))
