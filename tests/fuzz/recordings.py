"""Random recordings of axes and delta robots: any motion, torque and sampling, much of it unfit for a diagnosis."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.random import Generator

from recordings.importing import Description, import_data
from recordings.recording import Floats
from recordings.rig import Axis, Rig, Torque

USUAL_RATES, UNUSUAL_RATES = (100.0, 125.0, 200.0), (20.0, 50.0, 250.0, 500.0, 1000.0, 2000.0)
"""[Hz]; recordings of 1,500 rows are too short for most motions at the higher ones."""


@dataclass(frozen=True)
class Machine:
    """What is the same in all recordings of one case."""

    rig: Rig
    measures_effort: bool
    encoder_step: float
    """[rad or m]; 0: none."""
    scale: float
    """Of the torque."""
    inertia: Floats
    """(dof,)"""
    friction: Floats
    """(4, dof) viscous, Coulomb, constant, and with the angle."""


def machine(rng: Generator) -> Machine:
    """Draw a machine."""
    delta = rng.random() < 0.3
    dof = 3 if delta else int(rng.integers(1, 4))
    axes = tuple(
        Axis(type="revolute" if rng.random() < 0.7 else "prismatic", gravity=bool(rng.random() < 0.3))
        for _ in range(0 if delta else dof)
    )
    gain = tuple(float(10 ** rng.uniform(-2, 2)) for _ in range(dof)) if rng.random() < 0.5 else (1.0,) * dof
    torque = Torque(
        map="square" if rng.random() < 0.5 else "linear",
        gain=gain,
        gain_source="calibrated" if rng.random() < 0.5 else "assumed",
    )
    return Machine(
        rig=Rig(name="fuzz", mechanism="delta" if delta else "axes", axes=axes, torque=torque),
        measures_effort=bool(rng.random() < 0.4),
        encoder_step=0.0 if rng.random() < 0.4 else float(2 * np.pi / 2 ** rng.integers(10, 22)),
        scale=1.0 if rng.random() < 0.7 else float(10 ** rng.uniform(-9, 9)),
        inertia=10 ** rng.uniform(-2, 0.5, dof),
        friction=rng.uniform(0, 1, (4, dof)),
    )


def write(folder: Path, name: str, machine: Machine, rng: Generator, most: int) -> Path:
    """Write a random recording of the `machine`, of at most `most` rows, as CSV, and import it: NAME.mcap.

    Raises:
        BadInput: the import refuses the table.
    """
    rate = float(rng.choice(UNUSUAL_RATES if rng.random() < 0.1 else USUAL_RATES))
    rows = int(rng.integers(2, max(most // 3, 3)) if rng.random() < 0.05 else most * rng.uniform(0.4, 1))
    time = _instants(rng, rows, rate)
    motion, cycle = _motion(rng, time, machine.rig)
    torque = _torque(rng, machine, time, motion)
    table = {f"position_{i + 1}": column for i, column in enumerate(_read_by_encoder(rng, motion, machine).T)}
    torque = _damaged(rng, torque) * machine.scale
    signal = torque if machine.measures_effort else _volts(torque, machine.rig.torque)
    table |= {f"{'effort' if machine.measures_effort else 'voltage'}_{i + 1}": s for i, s in enumerate(signal.T)}
    if cycle is not None and rng.random() < 0.5:
        table["cycle"] = cycle
    kept = _kept_rows(rng, rows)
    path = folder / f"{name}.csv"
    columns = np.column_stack([time, *table.values()])[kept]
    lines = [",".join("" if np.isnan(value) else repr(float(value)) for value in row) for row in columns]
    path.write_text("\n".join([",".join(["time", *table]), *lines]) + "\n", encoding="utf-8")
    out = path.with_suffix(".mcap")
    import_data(path, out, Description(rig=machine.rig))
    return out


def _instants(rng: Generator, rows: int, rate: float) -> Floats:
    time = np.arange(rows) / rate
    kind = rng.random()
    if kind < 0.2:  # jitter
        time = time + rng.uniform(-0.4, 0.4, rows) / rate
    elif kind < 0.22:  # any step
        time = np.cumsum(rng.exponential(1 / rate, rows) + 1e-5)
    elif kind < 0.25:  # a clock with too few digits
        time = np.unique(np.round(time, int(rng.integers(2, 5))))
        time = np.concatenate([time, time[-1] + np.arange(1, rows - len(time) + 1) / rate])
    return time


def _kept_rows(rng: Generator, rows: int) -> Floats:
    """Indices of the rows that are recorded."""
    kept = np.arange(rows)
    if rng.random() < 0.05:
        kept = kept[:: int(rng.integers(2, 20))]
    if rng.random() < 0.2:  # gaps
        for _ in range(int(rng.integers(1, 5))):
            first = int(rng.integers(0, rows))
            kept = kept[(kept < first) | (kept > first + int(rng.integers(1, max(rows // 5, 2))))]
    return kept if len(kept) > 1 else np.arange(rows)


def _motion(rng: Generator, time: Floats, rig: Rig) -> tuple[Floats, Floats | None]:
    """(n, dof) positions, and (n,) numbers of the cycles where the motion is periodic."""
    span = max(float(time[-1] - time[0]), 1e-3)
    phase = (time - time[0]) / span
    kinds: tuple[Callable[[], Floats], ...] = (
        lambda: phase**2 * (3 - 2 * phase),
        lambda: (1 - np.cos(np.pi * phase)) / 2,
        lambda: phase,
        lambda: np.abs(2 * phase - 1),
        lambda: np.sin(2 * np.pi * rng.uniform(0.2, 40) * phase + rng.uniform(0, 7)),
        lambda: np.sin(np.cumsum(phase) * 0.3),
        lambda: np.where(phase < 0.8, 0.0, np.sin(20 * (phase - 0.8))),
        lambda: np.repeat(rng.uniform(-1, 1, 8), -(-len(phase) // 8))[: len(phase)],
        lambda: np.cumsum(rng.standard_normal(len(phase))) / np.sqrt(len(phase)),
        lambda: rng.standard_normal(len(phase)),
    )
    rough = rng.random() < 0.2
    dof, amplitude = rig.dof, float(10 ** rng.uniform(-2 if rng.random() < 0.1 else -1, 0.3))
    if rng.random() < 0.03:
        x, cycle = np.zeros((len(time), dof)), None
    elif rng.random() < 0.6:  # repeated sums of sines, as trajectories are
        cycles = int(rng.integers(1, 8))
        turns = cycles * phase
        harmonics = np.arange(1, 6)[:, None, None]
        amplitudes, shifts = rng.normal(0, 1, (5, 1, dof)) / harmonics, rng.uniform(0, 7, (5, 1, dof))
        x = (amplitudes * np.sin(2 * np.pi * harmonics * turns[:, None] + shifts)).sum(axis=0)
        cycle = np.minimum(np.floor(turns), cycles - 1)
    else:
        x, cycle = np.stack([kinds[rng.integers(len(kinds) if rough else 7)]() for _ in range(dof)], axis=1), None
    if rig.mechanism == "delta" and rng.random() < 0.9:
        amplitude = min(amplitude, 0.4)
    return 0.2 + amplitude * x, cycle


def _read_by_encoder(rng: Generator, position: Floats, machine: Machine) -> Floats:
    if machine.encoder_step:
        position = np.round(position / machine.encoder_step) * machine.encoder_step
    if rng.random() < 0.1:  # lost samples
        position = np.where(rng.random(position.shape) < 10 ** rng.uniform(-4, -2), np.nan, position)
    return position


def _torque(rng: Generator, machine: Machine, time: Floats, position: Floats) -> Floats:
    """(n, dof) torque of roughly such a machine."""
    velocity = np.gradient(position, time, axis=0)
    viscous, coulomb, constant, spring = machine.friction
    torque = machine.inertia * np.gradient(velocity, time, axis=0) + viscous * velocity + coulomb * np.sign(velocity)
    torque = torque + constant + spring * np.cos(position)
    if rng.random() < 0.5:  # what no base model has
        torque = torque + rng.uniform(0, 1) * np.sin(rng.uniform(1, 200) * position)
        torque = torque + rng.uniform(0, 1) * (time[:, None] > rng.uniform(0, time[-1]))
        torque = torque * (1 + rng.uniform(0, 0.5) * np.abs(velocity) / (1 + np.abs(velocity)))
    return torque + rng.standard_normal(position.shape) * float(10 ** rng.uniform(-4, 0))


def _damaged(rng: Generator, torque: Floats) -> Floats:
    """The torque as a poor channel reports it."""
    kind = rng.random()
    largest = max(float(np.quantile(np.abs(torque), 0.95)), 1e-12)
    rows, joints = np.arange(len(torque))[:, None], np.arange(torque.shape[1])
    ways: dict[float, Callable[[], Floats]] = {
        0.01: lambda: np.zeros_like(torque),
        0.02: lambda: np.full_like(torque, largest),
        0.12: lambda: rng.standard_normal(torque.shape),
        0.22: lambda: np.clip(torque, *(np.array([-1, 1]) * largest * rng.uniform(0.1, 1))),
        0.32: lambda: np.round(torque / largest * 2**9) / 2**9 * largest,
        0.40: lambda: np.where(rng.random(torque.shape) < 10 ** rng.uniform(-4, -2), np.nan, torque),
        0.41: lambda: np.where(joints == rng.integers(len(joints)), rng.choice([np.nan, 0.0, 1.0]), torque),
        0.50: lambda: np.where(torque > np.median(torque, axis=0), largest, 0.0),  # nearly constant, with a few steps
        0.54: lambda: np.where(rows == rng.integers(len(rows)), largest * 1e6, torque),  # one row that is far off
        1.00: lambda: torque,
    }
    return next(way() for share, way in ways.items() if kind < share)


def _volts(torque: Floats, torque_map: Torque) -> Floats:
    scaled = torque / np.array(torque_map.gain)
    return np.sign(scaled) * np.sqrt(np.abs(scaled)) if torque_map.map == "square" else scaled
