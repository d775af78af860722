"""Fits on the joints of effects whose parameters are searched for."""

from collections.abc import Callable

import numpy as np

from ident.diagnosis.search.search import Search
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, Term
from recordings.recording import Floats
from tests.ident import building
from tests.ident.building import drag

Change = Callable[[Motion, Floats, Floats], Floats]
"""Torque (n, 2) that the parameters of both joints add."""


def _signal(change: Change, scale: Floats | None = None) -> Signal:
    """A signal effect with one parameter on each joint."""

    def report(torque: Floats, inputs: EffectInputs, values: Values) -> Floats:
        return torque + change(inputs.motion, *np.asarray(values["a"]))

    return Signal(
        sentence="",
        symptom="",
        causes="",
        remedy="",
        equation="",
        axis="position",
        parameters=(Quantity(name="a", unit="{effort}", meaning="size", lower=0.0, initial_guesses=(1.0, 1.5)),),
        report=report,
        guess_scale=None if scale is None else lambda inputs: scale,
    )


def _search(signal: Signal) -> tuple[Search, tuple[ModelStructure, Floats]]:
    """A search where the first joint has twice the drag that the effect knows."""
    recording = building.record(2, noise=0.02, extra=lambda motion: drag(motion) * [2.0, 0.0])
    return building.search(building.split([recording]), {"signal": signal})


def test_model_on_one_more_joint_leaves_no_more() -> None:
    """From the mean of the others, the second joint starts where its torque does not depend on its parameter."""

    def change(motion: Motion, first: Floats, second: Floats) -> Floats:
        return drag(motion) * [first, 50 * min(second, 1.0)]

    signal = _signal(change)
    search, (structure, x) = _search(signal)
    one = search.fits.fit(structure.with_term(Term("signal", signal, (0,))), np.append(x, 1.0))
    both = search.fits.on_joints(one, 0, (0, 1))
    assert both.terms[0].joints == (0, 1)
    assert both.solution.loss < one.solution.loss * (1 + 1e-6)


def test_joints_that_linear_extrapolation_prefers_are_not_the_only_ones_where_guesses_are_scaled() -> None:
    """The parameter of the second joint changes the first one's torque; at the first guess it does so better."""

    def change(motion: Motion, first: Floats, second: Floats) -> Floats:
        ripple = np.cos(4 * motion.position)
        torque = first * (drag(motion) + (2 - first) * ripple) + second * (drag(motion) + (second - 0.7) * ripple)
        return torque * [1.0, 0.0]

    def joints(scale: Floats | None) -> tuple[tuple[int, ...], tuple[int, ...]]:
        search, begin = _search(_signal(change, scale))
        model, _ = search.start(*begin)
        candidate = search.candidates.screen(model).best["signal"]
        return candidate.term.joints, search.candidates.add(model, candidate).terms[0].joints

    assert joints(None) == ((1,), (1,))
    assert joints(np.array([1.0, 1.01])) == ((1,), (0,))
