"""Create a pair of recordings: a training motion and a different validation motion."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from daq.importing import Description, import_csv
from drivers.simulated.effect import HiddenEffect
from drivers.simulated.hidden import draw_effect
from recordings.errors import BadInput
from recordings.rig import load_rig
from tests.foreign import out_of_library, reference_motion, robots
from tests.foreign.plant import Plant, Reported, name
from tests.foreign.sizing import EffectSizer

_MAX_DRAWS = 4
_SIZE_TOLERANCE = 0.1
"""Relative tolerance of the sizes."""
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
    train = Plant(robot, reference_motion.draw(geometry, shape, rng, rate=setting.rate, seconds=20.0))
    validate = Plant(robot, reference_motion.draw(geometry, "fourier", rng, rate=setting.rate, seconds=12.0))
    sizer = EffectSizer(train) if effects else None
    sized = [_draw_of_size(rng, sizer, wanted, size) for wanted, size in zip(effects, sizes, strict=True) if sizer]
    write_pair(folder, train, validate, [effect for effect, _ in sized], setting, rng)
    return {"schema": 1, "seed": seed, "effects": [_truth_entry(effect, reached) for effect, reached in sized]}


def write_pair(
    folder: Path,
    train: Plant,
    validate: Plant,
    effects: Sequence[HiddenEffect],
    setting: Setting,
    rng: np.random.Generator,
) -> None:
    """Write train.mcap and validate.mcap of plants with the hidden `effects`, and their rig file, into `folder`."""
    (folder / "rig.toml").write_text(robots.rig_file(train.robot.rig), encoding="utf-8")
    for plant, out in ((train, TRAIN), (validate, VALIDATE)):
        _write(folder / out, plant.report(effects), plant, setting, rng)


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
    if wanted in out_of_library.KINDS:
        kind = out_of_library.KINDS[wanted]
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


def _write(out: Path, reported: Reported, plant: Plant, setting: Setting, rng: np.random.Generator) -> None:
    """Write a CSV file as described in docs/reference/recordings.md and import it as the recording `out`."""
    motion, rig = plant.reference, plant.robot.rig
    per_radian = np.array([drive.counts_per_radian for drive in rig.drives])
    position = np.rint(reported.position * per_radian) / per_radian
    voltage = reported.voltage + rng.normal(0.0, setting.volts, reported.voltage.shape)
    time = np.arange(len(position)) / rig.rate
    columns = [time[:, None], position, voltage, motion.repeat[:: motion.per_sample, None]]
    header = ["time", *(f"{quantity}_{i}" for quantity in ("position", "voltage") for i in (1, 2, 3)), "cycle"]
    table = out.with_suffix(".csv")
    formats = ["%.6f", *["%.9f"] * 3, *["%.5f"] * 3, "%d"]
    np.savetxt(table, np.hstack(columns), fmt=formats, delimiter=",", header=",".join(header), comments="")
    import_csv(table, out, Description(rig=load_rig(out.with_name("rig.toml"), driven=False), simulated=True))
    table.unlink()
