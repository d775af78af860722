"""Closing the loop: does the robot follow better with the effect that was found?

`make demo-control` or `python -m benchmarks.control [NAME ...]`: on the simulated rig with a hidden effect, records
two motions, fits the base model, diagnoses, and runs fig5b four times: without feed-forward, with Table 1 in Eq. (1),
with the fitted base model, and with the effects that were found. All drives have the servo below, with every effect.
Files are kept in runs/control.
"""

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks import programs
from ident.data.following_error import Following, following
from ident.dynamics.mechanisms import create
from ident.dynamics.motion import Motion
from recordings.reader import read
from recordings.rig import simulated_rig
from trajectories import load

FOLDER = Path("runs/control")
PICTURE = FOLDER / "following-error.png"
STEPS = ("none", "Table 1", "base model", "with the effect")
CYCLES = {"fig5a": 3, "fig5b": 4}
SERVO = """[servo]
position_gain = 25.0
velocity_gain = 30.0
integral_time = 0.05
exact_reference = true
"""
"""A cautious tuning: velocity loop of 15 Hz, position loop of 4 Hz, with velocity feed-forward."""
CASES = {
    "cogging": '[[effects]]\nname = "cogging"\nsize = 0.08\n',
    "joint_elasticity": '[[effects]]\nname = "joint_elasticity"\nparameters = { compliance = 1.5e-3 }\n',
    "payload_change": '[[effects]]\nname = "payload_change"\nparameters = { dm = 1.0, t_c = 8.0 }\n',
    "load_dependent_friction": '[[effects]]\nname = "load_dependent_friction"\nsize = 0.08\n',
    "position_dependent_friction": '[[effects]]\nname = "position_dependent_friction"\nsize = 0.08\n',
}
"""Hidden effects, as in a sim file."""


@dataclass(frozen=True)
class ClosedLoop:
    """Four runs with one hidden effect."""

    hidden: str
    effects: tuple[str, ...]
    """Effects that the diagnosis added."""
    runs: tuple[Following, ...]
    """In the order of STEPS."""

    @property
    def ratio(self) -> float:
        """Following error with the effects that were found over that with the base model."""
        return self.runs[3].overall / self.runs[2].overall

    @property
    def falls(self) -> bool:
        """Whether the following error falls at every step."""
        errors = [run.overall for run in self.runs]
        return all(after < before for before, after in pairwise(errors))


def main() -> None:
    """Run the cases named on the command line, or all, and show them."""
    cases = [run(name) for name in sys.argv[1:] or CASES]
    show(cases)
    draw(cases)
    print(f"picture: {PICTURE}")


def run(name: str) -> ClosedLoop:
    """Record, fit, diagnose and run four times with the hidden effect `name`."""
    folder = FOLDER / name
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.*"):
        if old.is_file():
            old.unlink()
    sim = folder / "sim.toml"
    sim.write_text(SERVO + CASES[name])
    train, none = _record(folder, sim, "fig5a", "train"), _record(folder, sim, "fig5b", "none")
    base, better = folder / "base.model.json", folder / "better.model.json"
    programs.call("ident", "fit", train, "--validate", none, "-o", base)
    diagnosis = programs.call("ident", "diagnose", train, "--validate", none, "--apply", "-o", better, "--json")
    feeds = [_table_1(folder), base, better]
    paths = [none, *(_record(folder, sim, "fig5b", f"feed-{k}", feed) for k, feed in enumerate(feeds, start=1))]
    effects = tuple(finding["effect"] for finding in json.loads(diagnosis)["findings"])
    case = ClosedLoop(name, effects, tuple(following(read(path)) for path in paths))
    print(f"{name}: {', '.join(f'{run.overall * 1e3:.3f}' for run in case.runs)} mrad", file=sys.stderr, flush=True)
    return case


def _record(folder: Path, sim: Path, motion: str, name: str, feed: Path | None = None) -> Path:
    out = folder / f"{name}.mcap"
    # Each run has noise of its own.
    options = ["--cycles", CYCLES[motion], "--seed", len(list(folder.glob("*.mcap"))), "--sim", sim]
    return programs.record(out, motion, *options, *(["--feedforward", feed] if feed else []))


def _table_1(folder: Path) -> Path:
    """Torque of Eq. (1) with Table 1 along fig5b, as a table."""
    rig = simulated_rig()
    path = load("fig5b", rig, CYCLES["fig5b"])
    velocity = path.joint_velocity
    motion = Motion(path.joint_position, velocity, path.joint_acceleration, np.sign(velocity))
    torque = create(rig).nominal_torque(motion)
    assert torque is not None
    names = ["time", *(f"{quantity}_{joint}" for quantity in ("position", "torque") for joint in (1, 2, 3))]
    rows = np.column_stack([path.time, path.joint_position, torque])
    np.savetxt(folder / "table_1.csv", rows, "%.9g", ",", header=",".join(names), comments="")
    return folder / "table_1.csv"


def show(cases: Sequence[ClosedLoop]) -> None:
    """Print one row per run."""
    print("Following error of fig5b [mrad]: RMS (worst) of joints 1, 2, 3; platform error [mm]: RMS (worst)")
    for case in cases:
        print(f"\nhidden: {case.hidden}; found: {', '.join(case.effects) or 'nothing'}")
        for step, result in zip(STEPS, case.runs, strict=True):
            joints = "  ".join(
                f"{rms * 1e3:6.3f} ({worst * 1e3:6.3f})" for rms, worst in zip(result.rms, result.worst, strict=True)
            )
            assert result.platform_rms is not None
            assert result.platform_worst is not None
            platform = f"{result.platform_rms * 1e3:6.3f} ({result.platform_worst * 1e3:6.3f})"
            print(f"  {step:16} {joints}   {platform}")
        steps = "falls at every step" if case.falls else "does not fall at every step"
        print(f"  {steps}; with the effect {case.ratio:.0%} of the base model's")


def draw(cases: Sequence[ClosedLoop]) -> None:
    """Draw the RMS over all joints, one group of bars per hidden effect."""
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    axes = figure.add_subplot()
    colours = ("#9aa0a6", "#c58b3b", "#4c78a8", "#2a9d63")
    for k, (step, colour) in enumerate(zip(STEPS, colours, strict=True)):
        values = [case.runs[k].overall * 1e3 for case in cases]
        places = np.arange(len(cases)) + 0.2 * (k - 1.5)
        bars = axes.bar(places, values, 0.19, color=colour, label=step)
        axes.bar_label(bars, [f"{value:.2g}" for value in values], fontsize=7, padding=1)
    axes.set_yscale("log")
    axes.set_xticks(range(len(cases)), [case.hidden.replace("_", "\n") for case in cases])
    axes.set_ylabel("following error, RMS of all joints [mrad]")
    axes.set_title(
        "The robot follows better with every step towards the true model (simulated rig, fig5b)", fontsize=10
    )
    axes.legend(title="torque fed forward", fontsize=8, title_fontsize=8, ncols=4, loc="upper center")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high * 2.5)
    axes.spines[["top", "right"]].set_visible(False)
    PICTURE.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(PICTURE, dpi=130)


if __name__ == "__main__":
    main()
