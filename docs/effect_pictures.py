"""A small picture of each effect along the paper's motion: its torque, and what a fit without it leaves of it."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import ident
from delta_web.palette import JOINTS, MEASURED
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.dynamics.effects.base import Effect
from ident.dynamics.term import Term
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Floats
from recordings.rig import Axis, Rig

SAMPLE = Path(__file__).parent.parent / "recordings" / "samples" / "fig5a.mcap"


def draw(name: str, effect: Effect, path: Path) -> None:
    """Draw the torque of `effect` on the first joint over time, and over its `axis` what a fit leaves of it."""
    prepared = _recorded("delta" if "delta" in effect.mechanisms else "axes")
    torque, left = _torque(name, effect, prepared)
    shown = slice(None) if effect.axis == "time" else prepared.first_cycle
    figure = Figure(figsize=(6.4, 1.9), layout="constrained")
    over_time, over_axis = figure.subplots(1, 2)
    over_time.plot(prepared.time[shown], torque[shown, 0], color=MEASURED, label="its torque")
    over_time.plot(prepared.time[shown], left[shown, 0], color=JOINTS[0], label="left in the residual")
    over_axis.plot(_quantity(effect, prepared)[shown], left[shown, 0], ".", markersize=2, color=JOINTS[0])
    over_time.set(xlabel="time [s]", ylabel="torque", yticks=[0], yticklabels=["0"])
    over_axis.set(xlabel=effect.axis, ylabel="residual", xticks=[], yticks=[0], yticklabels=["0"])
    figure.legend(fontsize="small", loc="outside upper center", ncols=2, frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def _torque(name: str, effect: Effect, prepared: PreparedRecording) -> tuple[Floats, Floats]:
    """(m, dof) torque of the effect on the first joint [N m], and what a fit of the mechanism leaves of it."""
    base, known = prepared.base_structure, _parameters(prepared.recording.rig.mechanism)
    joints = effect.possible_joints(base.rig)
    term = Term(name, effect, joints if effect.whole_robot else joints[:1])
    predictor = TorquePredictor(prepared)
    values = np.concatenate([known, _local(term), _shapes(term, predictor, known)])
    torque = predictor.torque(base.with_term(term), values) - predictor.torque(base, known)
    rows = np.isfinite(torque) & prepared.usable & np.isfinite(prepared.regressor).all(axis=2)
    fitted = np.linalg.lstsq(prepared.regressor[rows], torque[rows], rcond=None)[0]
    return torque, torque - prepared.regressor @ fitted


def _local(term: Term) -> list[float]:
    """Its parameters where a search begins; the values of a curve are a wave."""
    guesses = [quantity.first_guess for quantity in term.local_parameters]
    return [float(np.cos(number)) for number in range(len(guesses))] if term.effect.local_shapes else guesses


def _shapes(term: Term, predictor: TorquePredictor, known: Floats) -> Floats:
    """(s,) typical shapes; what is an instant without a guess lies in the middle of the run."""
    effect, prepared = term.effect, predictor.prepared
    if effect.local_shapes and effect.suggest:
        inputs = predictor.effect_inputs(prepared.base_structure, known)
        every = inputs.decimated(prepared.preprocessed.decimation)
        return term.shape_guesses(effect.suggest(every, prepared.torque))[0]
    middle = prepared.time[-1] / 2
    return np.array(
        [
            np.clip(middle if shape.searched else shape.upper, shape.lower, shape.upper)
            if shape.unit == "s" and not shape.initial_guesses
            else value
            for shape, value in zip(effect.shapes, effect.typical_shapes, strict=True)
        ]
    )


def _quantity(effect: Effect, prepared: PreparedRecording) -> Floats:
    """(m,) what the effect is drawn over, of the first joint."""
    if effect.axis == "time":
        return prepared.time
    if effect.axis == "load":
        return prepared.torque[:, 0]
    return getattr(prepared.motion, "position" if effect.axis == "motor angle" else effect.axis)[:, 0]


@cache
def _recorded(mechanism: str) -> PreparedRecording:
    """The sample, its drives getting warmer; or the motion and torque of its first joint as those of an axis."""
    sample = ident.read(SAMPLE)
    if mechanism == "axes":
        rig = Rig(name="axis", mechanism="axes", axes=(Axis(),))
        effort = sample.voltage[:, 0] * np.abs(sample.voltage[:, 0])
        return prepare(
            ident.Recording.from_arrays(sample.time, sample.position[:, 0], effort=effort, rig=rig), "parallel", None
        )
    warm = np.linspace(20.0, 40.0, len(sample.time))
    return prepare(replace(sample, extra={f"temperature_{joint}": warm for joint in (1, 2, 3)}), "parallel", None)


@cache
def _parameters(mechanism: str) -> Floats:
    model = ident.fit(_recorded(mechanism).recording, method="ls", bare=True)
    return np.array([float(value) for value in model.parameters.values()])
