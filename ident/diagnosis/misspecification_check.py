"""Whether one thing that nobody knows explains more than the effects that were added for want of a better one.

Something unknown is often imitated, more or less, by several known effects together. Then a curve in place of all of
them leaves less on rows that no fit has seen, and none of them belongs in the model.
"""

from ident.diagnosis.improvement import gain
from ident.diagnosis.nonparametric_fit import learn
from ident.diagnosis.split_data import Material
from ident.diagnosis.steps import Ladder, State
from ident.diagnosis.stepwise_selection import Climber, holds


def without_imitations(material: Material, climber: Climber, ladder: Ladder) -> Ladder:
    """The `ladder`, or as much of its beginning as a learned curve does not do better without."""
    top = ladder.rungs[-1].state
    first = max(i for i, rung in enumerate(ladder.rungs) if all(one.effect.always_true for one in rung.state.terms))
    if first == len(ladder.rungs) - 1:
        return ladder
    with_curves = [_with_curve(material, rung.state) for rung in ladder.rungs[first:]]
    best = min(with_curves, key=lambda state: _held_out(material, state, ladder))
    for number, state in enumerate(with_curves[:-1], start=first):
        if _better(material, top, state, ladder) and not _better(material, state, best, ladder):
            return climber.stopped(ladder, number)
    return ladder


def _with_curve(material: Material, state: State) -> State:
    learned = learn(material, state)
    return learned.after if learned else state


def _held_out(material: Material, state: State, ladder: Ladder) -> float:
    nothing = [data.torque * 0.0 for data in material.datasets]
    return -gain(material, nothing, state.residuals, ladder.floor.rms).fall


def _better(material: Material, before: State, after: State, ladder: Ladder) -> bool:
    return holds(gain(material, before.residuals, after.residuals, ladder.floor.rms))
