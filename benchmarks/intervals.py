"""Measure how often the 95 % intervals of `ident fit` and `ident diagnose` hold the true parameters.

`python -m benchmarks.intervals [--cases 60] [--bits 16]`. Robots, motions, signals and encoders are those of the part
`chosen` of the hidden effects. Recordings have nothing hidden, or an effect that the model is given, since intervals
are conditional on the model. They are those for an exactly known gain, as the gain of these robots is.
"""

import re
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import click
import numpy as np

from benchmarks.hidden_effects.cases import HiddenCase
from benchmarks.hidden_effects.drawn_cases import drawn_cases
from benchmarks.hidden_effects.figures import Figure
from benchmarks.hidden_effects.foreign import setting_of
from benchmarks.programs import claim
from ident.diagnosis.diagnosis import DiagnosisOptions, prepare_inputs
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.dynamics.effects.library import library
from ident.dynamics.structure import Term
from ident.estimation import estimators
from ident.identification.identify import FitOptions, identify
from recordings.errors import BadInput
from recordings.recording import Floats
from tests.foreign import robots
from tests.foreign.pairs import TRAIN, VALIDATE, make

EFFECTS = (
    "stribeck",
    "power_law_friction",
    "thermal_drift",
    "quadratic_friction",
    "torque_offset",
    "amplifier_saturation",
)
"""Effects whose parameters have the same names in the plant and in `ident`."""
_GRAVITY = 9.81
ACCEPTED = 93.0, 97.0

Truth = Mapping[str, float]
Intervals = Mapping[str, tuple[float, float]]
Hits = dict[str, list[bool]]
"""Whether each interval holds the truth, by the name of the parameter without its joint."""


def record(case: HiddenCase, folder: Path) -> tuple[Truth, list[dict[str, Any]]] | None:
    """Write the recordings of `case`; return the true parameters and the effects, or None if they are impossible."""
    try:
        truth = make(folder, case.effects, case.sizes, case.seed, setting_of(case))
    except BadInput:
        return None
    robot = robots.draw(  # the first that `make` draws
        case.robot,
        np.random.default_rng(case.seed),
        rate=case.rate,
        bits=case.bits,
        reports_command=case.reports_command,
    )
    hidden = truth["effects"]
    return dict(_machine(robot)) | {name: value for effect in hidden for name, value in _effect(effect)}, hidden


def _machine(robot: robots.Robot) -> Iterator[tuple[str, float]]:
    links, friction = robot.links, robot.friction
    yield "m_p", links.platform_mass + links.payload
    yield "T_g", links.arm_mass * links.arm_com * _GRAVITY
    yield "rod_inertia.m_d", links.rod_mass
    for joint in range(3):
        yield f"I_{joint + 1}", links.arm_inertia + links.arm_mass * links.arm_com**2 + links.motor_inertia
        yield f"c_v{joint + 1}", friction.viscous[joint]
        yield f"c_c{joint + 1}", friction.coulomb[joint]


def _effect(effect: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    values = effect["parameters"]
    if effect["name"] == "thermal_drift":
        values = values | {"a": values["b"] * values["viscous"]}
    for name, value in values.items():
        for joint in ("", *effect["joints"]):
            yield f"{effect['name']}.{name}{joint}", value


def of_fit(folder: Path) -> Intervals:
    """Intervals of `ident fit` by weighted least squares."""
    options = FitOptions("wls", estimators.settings("wls", {}), 0, "parallel", None, base_effects=True)
    model = identify([folder / TRAIN], (), options, lambda *_: None).model
    return {parameter.name: parameter.shape_ci95 for parameter in model.parameters if parameter.shape_ci95}


def of_diagnosis(folder: Path, truth: Truth, hidden: list[dict[str, Any]]) -> Intervals:
    """Intervals of `ident diagnose` for the model with the `hidden` effects, fitted from the `truth`."""
    effects = library()
    split = prepare_inputs([folder / TRAIN], [folder / VALIDATE], effects, DiagnosisOptions()).split
    structure = split.recordings[0].base_structure
    for name, joints in (("rod_inertia", ()), *((effect["name"], effect["joints"]) for effect in hidden)):
        term = Term.on_all_joints(name, effects[name], structure.rig)
        structure = structure.with_term(
            term if effects[name].whole_robot else replace(term, joints=tuple(joint - 1 for joint in joints))
        )
    start = np.array([truth[entry.name] for entry in structure.parameters])
    solution = split.fit(structure, start)
    intervals: Floats = FittedModel(split, solution).shape_intervals
    return {
        entry.name: (low, high)
        for entry, (low, high) in zip(structure.parameters, intervals.tolist(), strict=True)
        if np.isfinite([low, high]).all()
    }


def _add(hits: Hits, intervals: Intervals, truth: Truth) -> None:
    for name, (low, high) in intervals.items():
        hits.setdefault(re.sub(r"_?[123]$", "", name), []).append(low <= truth[name] <= high)


def _lines(fits: Hits, diagnoses: Hits) -> Iterator[str]:
    yield f"{'intervals that hold the truth':34}{'ident fit':34}ident diagnose"
    rows = {name: (fits.get(name, []), hits) for name, hits in diagnoses.items()}
    rows["all"] = (list(chain(*fits.values())), list(chain(*diagnoses.values())))
    for name, cells in rows.items():
        yield f"{name:34}" + "".join(f"{Figure('', hits).cell if hits else '':34}" for hits in cells).rstrip()


@click.command()
@click.option(
    "--cases", default=60, show_default=True, help="Number of recordings with nothing hidden, and of others."
)
@click.option("--bits", type=click.IntRange(8, 30), help="Resolution of all encoders.  [default: 16 to 20]")
def main(cases: int, bits: int | None) -> None:
    """Print a table with a row for each kind of parameter; in parentheses: 95 % interval (Wilson)."""
    drawn = drawn_cases("chosen")
    selected = [case for case in drawn if case.kind == "nothing"][:cases]
    selected += [case for case in drawn if case.kind == "single" and case.effects[0] in EFFECTS][:cases]
    fits: Hits = {}
    diagnoses: Hits = {}
    for case in selected:
        case = replace(case, bits=bits or case.bits)
        with tempfile.TemporaryDirectory() as name:
            recorded = record(case, Path(name))
            if recorded is None:
                continue
            truth, hidden = recorded
            if not hidden:
                _add(fits, of_fit(Path(name)), truth)
            _add(diagnoses, of_diagnosis(Path(name), truth, hidden), truth)
    click.echo("\n".join(_lines(fits, diagnoses)))
    everything = [Figure("", list(chain(*hits.values())), *ACCEPTED) for hits in (fits, diagnoses)]
    claim(
        "95 % intervals hold the truth in 93 to 97 %, but for chance", not any(x.clearly_missed for x in everything)
    )


if __name__ == "__main__":
    main()
