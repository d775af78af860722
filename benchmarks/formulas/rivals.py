"""What learns the residual without mechanics: the rivals of a formula, with the settings that they compete with.

All get the motion and load of all joints and the time, at the training rows of the joints on which the last model of
a diagnosis leaves something, and are scored on the held-out rows. They are in the extra `bench`.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.split_data import rms
from ident.dynamics.effects.quantities import quantity
from recordings.recording import Floats

_QUANTITIES = ("q", "qd", "qdd", "direction", "load", "t")


def _sindy() -> Any:
    """Sparse regression, as in pysindy, over polynomials of second degree and sines of all inputs."""
    from pysindy import STLSQ, FourierLibrary, PolynomialLibrary
    from sklearn.pipeline import FeatureUnion, make_pipeline
    from sklearn.preprocessing import StandardScaler

    columns = FeatureUnion([("powers", PolynomialLibrary(degree=2)), ("waves", FourierLibrary(n_frequencies=2))])
    return make_pipeline(StandardScaler(), columns, STLSQ(threshold=0.02, alpha=0.05))


def _genetic() -> Any:
    """Symbolic regression by genetic programming."""
    from gplearn.genetic import SymbolicRegressor

    return SymbolicRegressor(
        population_size=1000,
        generations=15,
        function_set=("add", "sub", "mul", "div", "sin", "cos", "abs", "max", "min"),
        parsimony_coefficient=1e-4,
        metric="mse",
        max_samples=0.2,
        random_state=0,
    )


def _boosted() -> Any:
    """Trees by gradient boosting."""
    from sklearn.ensemble import HistGradientBoostingRegressor

    return HistGradientBoostingRegressor(learning_rate=0.05, max_iter=300, l2_regularization=1.0, random_state=0)


RIVALS: dict[str, Callable[[], Any]] = {"pysindy": _sindy, "gplearn": _genetic, "boosted": _boosted}


def compete(name: str, diagnosis: Diagnosis) -> dict[str, Any]:
    """Held-out error per joint [N m] of the last model with what the rival `name` learns, and its time [s]."""
    start, model = time.monotonic(), diagnosis.model
    residuals = [residual.copy() for residual in model.residuals]
    inputs = _inputs(model)
    for joint in diagnosis.unexplained.joints:
        known = [
            np.isfinite(each).all(axis=1) & np.isfinite(residual[:, joint])
            for each, residual in zip(inputs, residuals, strict=True)
        ]
        rows = [both & train[:, joint] for both, train in zip(known, model.split.train, strict=True)]
        x, y = (
            np.concatenate([each[selected] for each, selected in zip(values, rows, strict=True)])
            for values in (inputs, [residual[:, joint] for residual in residuals])
        )
        learned = RIVALS[name]().fit(x, y / y.std())
        for each, residual, selected in zip(inputs, residuals, known, strict=True):
            residual[selected, joint] -= y.std() * np.ravel(learned.predict(each[selected]))
    return {"after": rms(residuals, model.split.test).tolist(), "seconds": time.monotonic() - start}


def _inputs(model: FittedModel) -> list[Floats]:
    """(m, k) quantities of all joints on each recording; NaN where unknown."""
    structure, x = model.solution.structure, model.solution.x
    inputs = [
        replace(each.effect_inputs(structure, x), motion=each.prepared.motion, time=each.prepared.time)
        for each in model.split.predictors
    ]
    return [np.column_stack([quantity(name, each) for name in _QUANTITIES]) for each in inputs]
