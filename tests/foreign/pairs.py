"""Create a pair of recordings: a training motion and a different validation motion."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from drivers.simulated.effect import HiddenEffect
from drivers.simulated.hidden import draw_effect
from recordings.errors import BadInput
from recordings.importing import Description, import_data
from recordings.recording import Floats
from recordings.rig import load_rig
from tests.foreign import reference_motion, robots
from tests.foreign.plant import KINDS, Plant, Reported, name
from tests.foreign.sizing import EffectSizer

_MAX_DRAWS = 4
_SIZE_TOLERANCE = 0.1
"""Relative tolerance of the sizes."""
_RANGE = 1.25
"""Range of the drives' voltages over the largest one that occurs."""
TRAIN, VALIDATE = "train.mcap", "validate.mcap"


@dataclass(frozen=True)
class Setting:
    """Conditions of a pair of recordings."""

    robot: robots.Kind = "default"
    volts: float = 0.01
    """Standard deviation of the voltage's noise [V]."""
    bits: int = 18
    """Encoder resolution per turn of the joint [bit]."""
    rate: float = 500.0
    """[Hz]"""
    reports_command: bool = False
    """Whether voltages are commanded ones, before the effects of the amplifiers."""
    repeats: bool = True
    """Whether both motions consist of identical cycles; otherwise nothing in them repeats."""
    signal: Literal["voltage", "effort"] = "voltage"
    """What the drives report; the effort has the noise of the voltage at its RMS value."""
    signal_bits: int | None = None
    """Resolution of this signal over its range [bit]; None: no steps."""


def make(
    folder: Path, effects: Sequence[str], sizes: Sequence[float], seed: int, setting: Setting = Setting()
) -> dict[str, Any]:
    """Write train.mcap, validate.mcap and their rig file into the existing `folder`; return the truth.

    effects: different names; sizes: size of each effect alone on the training motion.

    Raises:
        BadInput: an effect is unknown or cannot have its size on this robot.
    """
    rng = np.random.default_rng(seed)
    robot = robots.draw(
        setting.robot, rng, rate=setting.rate, bits=setting.bits, reports_command=setting.reports_command
    )
    geometry = robot.rig.geometry
    shape: reference_motion.Shape = "stations" if rng.random() < 0.5 else "fourier"
    draw_motion = partial(reference_motion.draw, geometry, rng=rng, rate=setting.rate, repeats=setting.repeats)
    train = Plant(robot, draw_motion(shape, seconds=20.0))
    validate = Plant(robot, draw_motion("fourier", seconds=12.0))
    sizer = EffectSizer(train) if effects else None
    sized = [_draw_of_size(rng, sizer, wanted, size) for wanted, size in zip(effects, sizes, strict=True) if sizer]
    _write_pair(folder, train, validate, [effect for effect, _ in sized], setting, rng)
    return {"schema": 1, "seed": seed, "effects": [_truth_entry(effect, reached) for effect, reached in sized]}


def _write_pair(
    folder: Path,
    train: Plant,
    validate: Plant,
    effects: Sequence[HiddenEffect],
    setting: Setting,
    rng: np.random.Generator,
) -> None:
    """Write train.mcap and validate.mcap of plants with the hidden `effects`, and their rig file, into `folder`."""
    (folder / "rig.toml").write_text(robots.rig_file(train.robot.rig), encoding="utf-8")
    reports = [plant.report(effects) for plant in (train, validate)]
    largest = _RANGE * max(float(np.abs(reported.voltage).max()) for reported in reports)
    for plant, reported, out in zip((train, validate), reports, (TRAIN, VALIDATE), strict=True):
        _write(folder / out, reported.position, _signal(reported, train.robot, setting, largest, rng), plant, setting)


def _draw_of_size(
    rng: np.random.Generator, sizer: EffectSizer, wanted: str, size: float
) -> tuple[HiddenEffect, float]:
    """Draw an effect `wanted` of about the `size`; return it and its actual size."""
    for _ in range(_MAX_DRAWS):
        effect = _draw_effect(rng, wanted)
        scaled = sizer.nearest(effect, size)
        if scaled and abs(scaled[1] / size - 1) < _SIZE_TOLERANCE:
            return scaled
    raise BadInput(f"{wanted}: a size that it can have on this robot expected, {size:g} found; choose another")


def _draw_effect(rng: np.random.Generator, wanted: str) -> HiddenEffect:
    if wanted in KINDS:
        kind = KINDS[wanted]
        return kind(joints=kind.draw_joints(rng), **kind.draw_shape(rng))
    return draw_effect(rng, [wanted])


def _truth_entry(effect: HiddenEffect, size: float) -> dict[str, Any]:
    return {
        "name": name(effect),
        "joints": list(effect.joints),
        "parameters": effect.model_dump(exclude={"joints"}),
        "size": size,
        "in_library": effect.in_library(),
        "depends_on": list(effect.depends_on()),
    }


def _signal(
    reported: Reported, robot: robots.Robot, setting: Setting, largest: float, rng: np.random.Generator
) -> Floats:
    """(m, 3) what the drives report, with noise and steps [V or N m]; largest: the end of their range [V]."""
    signal, noise, gain = reported.voltage, setting.volts, np.array(robot.rig.torque.gain)
    if setting.signal == "effort":
        noise = noise * 2 * gain * np.sqrt(np.mean(signal**2))
        signal, largest = gain * signal * np.abs(signal), float(gain.max()) * largest**2
    noisy: Floats = signal + rng.normal(0.0, noise, signal.shape)
    if setting.signal_bits is None:
        return noisy
    step = 2 * largest / 2**setting.signal_bits
    rounded: Floats = step * np.rint(noisy / step)
    return rounded


def _write(out: Path, position: Floats, signal: Floats, plant: Plant, setting: Setting) -> None:
    """Write a CSV file as described in docs/reference/recordings.md and import it as the recording `out`."""
    motion, rig = plant.reference, plant.robot.rig
    per_radian = np.array([drive.counts_per_radian for drive in rig.drives])
    time = np.arange(len(position)) / rig.rate
    columns = [time[:, None], np.rint(position * per_radian) / per_radian, signal]
    header = ["time", *(f"{quantity}_{i}" for quantity in ("position", setting.signal) for i in (1, 2, 3))]
    formats = ["%.6f", *["%.9f"] * 3, *["%.5f"] * 3]
    if setting.repeats:
        columns, header, formats = (
            [*columns, motion.repeat[:: motion.per_sample, None]],
            [*header, "cycle"],
            [*formats, "%d"],
        )
    table = out.with_suffix(".csv")
    np.savetxt(table, np.hstack(columns), fmt=formats, delimiter=",", header=",".join(header), comments="")
    import_data(table, out, Description(rig=load_rig(out.with_name("rig.toml"), driven=False), simulated=True))
    table.unlink()
