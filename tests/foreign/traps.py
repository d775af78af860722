"""Recordings of one axis that invite false names: what a real machine shows and no effect of the library is."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from scipy.signal import lfilter

from recordings.importing import Description, import_data
from recordings.recording import Floats
from tests.foreign.pairs import TRAIN, VALIDATE

Kind = Literal[
    "rising_speed",
    "single_stroke",
    "single_speed",
    "undeclared_weight",
    "sublinear_friction",
    "heavy_axis",
    "turned_motor",
    "slow_turns",
]
KINDS: tuple[Kind, ...] = get_args(Kind)
"""Speed that rises with time; one stroke without return; one speed in both directions, beside a vibration; weight
that the rig file does not declare; friction c |v|^0.5 sgn v; weight of many times the friction; an offset of a motor
that is turned hundreds of times; weight and an offset over tens of slow turns."""
_LINEAR = ("undeclared_weight", "heavy_axis", "turned_motor", "slow_turns")
"""Those whose friction is viscous."""

_SECONDS = {"train": 20.0, "validate": 12.0}
_RATES = (250.0, 500.0, 1000.0)
_BITS = (14, 16, 18)
"""Encoder resolution per turn of the joint [bit]."""
_NOISE = (0.005, 0.02)
"""Range of the standard deviation of the torque's noise, relative to the friction."""
_FINE = 4
"""Instants of the true motion per sample."""
_LAG = 0.012
"""Time constant of the position loop [s]."""
_SWAY = 2e-4
"""Standard deviation by which the loop lets the joint sway about its path [rad]."""
_SLOW = 0.25
"""The sway's time constant [s]."""
_MIN_SPEED = 1e-3
"""Half-width of the rounded corner of the dry friction [rad/s]."""

Path1d = Callable[[Floats], Floats]
"""Reference angle (n,) [rad] at the instants (n,) [s]."""


@dataclass(frozen=True)
class Axis:
    """True parameters of an axis."""

    inertia: float
    coulomb: float
    drag: float
    exponent: float
    """Friction coulomb sgn v + drag |v|^exponent sgn v."""
    weight: float
    """Amplitude of the weight's torque [N m]."""
    weight_angle: float
    offset: float
    """[N m]"""
    vibration: float
    """Amplitude of a torque at a fixed frequency [N m]."""
    frequency: float


@dataclass(frozen=True)
class Setting:
    """How the axis is recorded."""

    rate: float
    bits: int
    noise: float
    """Standard deviation of the torque's noise [N m]."""
    signal: Literal["effort", "linear", "square"]
    """Torque, or the voltage commanded through this torque map."""
    held_out: bool
    """Whether there is a second recording."""


def make(folder: Path, kind: Kind, seed: int) -> Setting:
    """Write train.mcap and, for every second seed, validate.mcap into the existing `folder`."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    axis = _draw_axis(kind, rng)
    setting = Setting(
        rate=float(rng.choice(_RATES)),
        bits=int(rng.choice(_BITS)),
        noise=float(axis.coulomb * rng.uniform(*_NOISE)),
        signal=rng.choice(("effort", "linear", "square")),
        held_out=seed % 2 == 0,
    )
    names = {"train": TRAIN, "validate": VALIDATE}
    for part in ("train", "validate") if setting.held_out else ("train",):
        path = _draw_path(kind, _SECONDS[part], rng)
        _write(folder / names[part], axis, path, _SECONDS[part], setting, rng)
    return setting


def _draw_axis(kind: Kind, rng: np.random.Generator) -> Axis:
    """A joint of a robot arm: friction dominates, and rises less than linearly with the speed."""
    coulomb, vibrates = rng.uniform(0.5, 3.0), kind == "single_speed"
    weights = {"undeclared_weight": (0.5, 4.0), "heavy_axis": (10.0, 40.0), "slow_turns": (0.5, 4.0)}
    before_gear = 0.01 if kind == "turned_motor" else 1.0  # a motor is fast, and light
    return Axis(
        inertia=before_gear * rng.uniform(0.1, 0.5),
        coulomb=coulomb,
        drag=before_gear * coulomb * rng.uniform(0.5, 1.5),
        exponent=1.0 if kind in _LINEAR else 0.5,
        weight=coulomb * rng.uniform(*weights[kind]) if kind in weights else 0.0,
        weight_angle=rng.uniform(-np.pi, np.pi),
        offset=coulomb * rng.uniform(0.1, 0.5) if kind in ("turned_motor", "slow_turns") else 0.0,
        vibration=coulomb * rng.uniform(0.05, 0.2) if vibrates else 0.0,
        frequency=rng.uniform(4.0, 9.0),
    )


def _draw_path(kind: Kind, seconds: float, rng: np.random.Generator) -> Path1d:
    """A reference: angle over time."""
    if kind == "rising_speed":
        size, first, last = rng.uniform(0.3, 1.0), rng.uniform(0.05, 0.15), rng.uniform(0.4, 0.8)
        return lambda t: size * np.sin(2 * np.pi * (first * t + (last - first) * t**2 / (2 * seconds)))
    if kind == "single_stroke":
        travel, rest = rng.uniform(2.0, 6.0), 0.1 * seconds
        bend = rng.uniform(0.0, 0.15)
        return lambda t: _stroke(np.clip((t - rest) / (seconds - 2 * rest), 0.0, 1.0), travel, bend)
    if kind == "single_speed":
        half, speed = rng.uniform(0.4, 1.2), rng.uniform(0.3, 1.0)
        return lambda t: half * _rounded_triangle(speed * t / (2 * np.pi * half) * (np.pi / 2))
    if kind in ("turned_motor", "slow_turns"):
        turns, there_and_back = rng.uniform(100, 300) if kind == "turned_motor" else rng.uniform(5, 15), seconds / 2
        return lambda t: np.pi * turns * _rounded_triangle(t / there_and_back)
    phases, size = rng.uniform(0, 2 * np.pi, 5), rng.uniform(0.4, 1.2)
    period = float(seconds / rng.integers(2, 6))
    return lambda t: sum(
        (size / n**1.2 * np.sin(2 * np.pi * n * t / period + phase) for n, phase in enumerate(phases, start=1)),
        np.zeros_like(t),
    )


def _stroke(share: Floats, travel: float, bend: float) -> Floats:
    """Accelerate, move on with a speed that changes slowly, and stop, without a return."""
    ramp = 0.25
    speed = np.minimum(1.0, np.minimum(share, 1 - share) / ramp)
    speed = speed**2 * (3 - 2 * speed) * (1 + bend * np.sin(2 * np.pi * share))
    path = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))])
    return np.asarray(travel * path / path[-1])


def _rounded_triangle(turns: Floats) -> Floats:
    """A triangle wave of amplitude one over `turns`, whose reversals take a tenth of the time."""
    order = np.arange(1, 20, 2)[:, None]
    smoothing = np.exp(-((order * 0.08) ** 2))
    waves = (-1) ** ((order - 1) // 2) * smoothing * np.sin(2 * np.pi * order * turns) / order**2
    return np.asarray(8 / np.pi**2 * waves.sum(axis=0))


def _write(out: Path, axis: Axis, path: Path1d, seconds: float, setting: Setting, rng: np.random.Generator) -> None:
    step = 1 / (setting.rate * _FINE)
    time: Floats = (np.arange(round(seconds / step)) * step).astype(float)
    position = _followed(path(time), step, rng)
    velocity = np.gradient(position, step)
    torque = _torque(axis, time, position, velocity, np.gradient(velocity, step))
    mean = np.convolve(torque, np.ones(_FINE) / _FINE, "same")[::_FINE]
    mean = mean + rng.normal(0.0, setting.noise, len(mean))
    counts = 2**setting.bits / (2 * np.pi)
    measured = np.rint(position[::_FINE] * counts) / counts
    signal = mean if setting.signal != "square" else np.sign(mean) * np.sqrt(np.abs(mean))
    quantity = "effort" if setting.signal == "effort" else "voltage"
    table = out.with_suffix(".csv")
    np.savetxt(
        table,
        np.column_stack([time[::_FINE], measured, signal]),
        fmt=["%.6f", "%.9f", "%.6f"],
        delimiter=",",
        header=f"time,position_1,{quantity}_1",
        comments="",
    )
    torque_map = None if setting.signal == "effort" else {"map": setting.signal, "gain": [1.0]}
    import_data(table, out, Description(mechanism="axes", torque=torque_map, simulated=True))
    table.unlink()


def _followed(reference: Floats, step: float, rng: np.random.Generator) -> Floats:
    """Angle (n,) of a joint that lags behind the `reference` and sways a little: no two cycles are equal."""
    decay, slow = np.exp(-step / _LAG), np.exp(-step / _SLOW)
    sway = lfilter([1 - slow], [1, -slow], rng.normal(size=len(reference)))
    path = reference + _SWAY * sway / sway.std()
    for _ in range(3):
        path = lfilter([1 - decay], [1, -decay], path - path[0]) + path[0]
    return np.asarray(path)


def _torque(axis: Axis, time: Floats, q: Floats, v: Floats, a: Floats) -> Floats:
    direction = np.tanh(v / _MIN_SPEED)
    friction = (axis.coulomb + axis.drag * np.abs(v) ** axis.exponent) * direction
    weight = axis.weight * np.sin(q - axis.weight_angle)
    vibration = axis.vibration * np.sin(2 * np.pi * axis.frequency * time)
    return np.asarray(axis.inertia * a + friction + weight + axis.offset + vibration)
