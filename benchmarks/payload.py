"""Test whether a payload that is picked up at any instant of a repeated motion is named, on foreign robots.

`python -m benchmarks.payload [NUMBER ...]`: 40 instants, among them the middle of the recording and the seams between
its five cycles; in every fourth case the payload is put down again. Recordings are kept in runs/payload.
"""

import shutil
import sys
from pathlib import Path
from typing import get_args

import numpy as np

import ident
from drivers.simulated.effects.payload_change import PayloadChange
from tests.foreign import reference_motion, robots
from tests.foreign.pairs import TRAIN, VALIDATE, Setting, write_pair
from tests.foreign.plant import Plant

COUNT, CYCLES, SECONDS = 40, 5, 20.0
"""Number of cases, cycles of the training motion, and its approximate duration [s]."""
HELD_OUT_SECONDS = (6.0, 12.0, 20.0)
"""Durations of the held-out motion [s]."""
WINDOW_EVERY, WINDOW = 4, 1.3
"""In every so many cases the payload is put down after this number of cycles."""
MASSES = {"default": 0.5, "heavy": 2.0, "light": 0.15}
"""Mass of the payload [kg]."""
RATES, NOISES, BITS = (200.0, 250.0, 500.0, 1000.0), (0.005, 0.01, 0.02), (16, 17, 18, 20)
"""Sampling rates [Hz], noise of the voltage [V], encoder resolutions [bit]."""
FOLDER = Path("runs/payload")


def main() -> None:
    """Diagnose the cases, or those with the numbers given on the command line."""
    numbers = [int(argument) for argument in sys.argv[1:]] or range(COUNT)
    named = [_run(number) for number in numbers]
    print(f"payload_change is named in {sum(named)} of {len(named)}")


def instant(number: int) -> float:
    """When the payload is picked up, in cycles: the middle, the seams, and instants spread over the recording."""
    special = (CYCLES / 2, *range(1, CYCLES))
    spread = np.linspace(0.25, CYCLES - 0.25, COUNT - len(special))
    return float([*special, *spread][number])


def record(number: int, folder: Path) -> PayloadChange:
    """Write the recordings of case `number` into `folder`; return the hidden effect."""
    rng = np.random.default_rng([17, number])
    setting = Setting(
        get_args(robots.Kind)[number % 3], float(rng.choice(NOISES)), int(rng.choice(BITS)), float(rng.choice(RATES))
    )
    robot = robots.draw(setting.robot, rng, rate=setting.rate, bits=setting.bits, reports_command=False)
    geometry, rate = robot.rig.geometry, setting.rate
    shape: reference_motion.Shape = "stations" if number % 2 else "fourier"
    train = Plant(robot, reference_motion.draw(geometry, shape, rng, rate=rate, seconds=SECONDS, cycles=CYCLES))
    # The shorter ones often end before the payload is picked up.
    seconds = float(rng.choice(HELD_OUT_SECONDS))
    validate = Plant(robot, reference_motion.draw(geometry, "fourier", rng, rate=rate, seconds=seconds))
    cyclic = train.reference.time[train.reference.repeat >= 0]
    period = len(cyclic) * train.reference.step / CYCLES
    effect = PayloadChange(joints=(1, 2, 3), dm=MASSES[setting.robot], t_c=cyclic[0] + instant(number) * period)
    if number % WINDOW_EVERY == WINDOW_EVERY - 1:
        effect = effect.model_copy(update={"t_e": effect.t_c + WINDOW * period})
    write_pair(folder, train, validate, [effect], setting, rng)
    return effect


def _run(number: int) -> bool:
    folder = FOLDER / str(number)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    effect = record(number, folder)
    document = ident.diagnose([folder / TRAIN], validate=folder / VALIDATE).document
    findings = [finding for finding in document.findings if finding.effect != "rod_inertia"]
    named = bool(findings) and "payload_change" in (findings[0].effect, *findings[0].confusable_with)
    names = ", ".join(" or ".join((finding.effect, *finding.confusable_with)) for finding in findings) or "nothing"
    floor, error = (
        np.round([value or np.nan for value in values], 4).tolist()
        for values in (document.noise_rms, document.steps[-1].held_out_rms)
    )
    print(
        f"{number:2} {instant(number):.2f} cycles, t_c {effect.t_c:.2f} s: {'' if named else 'MISSED, '}"
        f"{document.verdict} {names}; floor {floor}, held out {error}; {document.remaining.why}",
        flush=True,
    )
    return named


if __name__ == "__main__":
    main()
