"""What learns the residual without mechanics: the rivals of a formula, with the settings that they compete with.

All get the motion and load of all joints and the time, at the training rows of the joints on which the last model of
a diagnosis leaves something, and are scored on the held-out rows. They need gplearn, pysindy and scikit-learn.
"""

import time
from dataclasses import replace
from typing import Any

import numpy as np

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.split.split_data import rms
from ident.dynamics.effects.quantities import quantity

RIVALS = ("pysindy", "gplearn", "boosted")
_QUANTITIES = ("q", "qd", "qdd", "direction", "load", "t")


def _regressor(name: str) -> Any:
    """The rival `name`; inputs and target have unit variance."""
    from gplearn.genetic import SymbolicRegressor
    from pysindy import STLSQ, FourierLibrary, PolynomialLibrary
    from sklearn.ensemble import HistGradientBoostingRegressor
    from sklearn.pipeline import make_pipeline, make_union

    columns = make_union(PolynomialLibrary(degree=2), FourierLibrary(n_frequencies=2))
    functions = ("add", "sub", "mul", "div", "sin", "cos", "abs", "max", "min")
    return {
        "pysindy": make_pipeline(columns, STLSQ(threshold=0.02, alpha=0.05)),
        "gplearn": SymbolicRegressor(
            population_size=1000,
            generations=15,
            function_set=functions,
            metric="mse",
            parsimony_coefficient=1e-3,
            max_samples=0.2,
            random_state=0,
        ),
        "boosted": HistGradientBoostingRegressor(
            learning_rate=0.05, max_iter=300, l2_regularization=1.0, random_state=0
        ),
    }[name]


def compete(name: str, diagnosis: Diagnosis) -> dict[str, Any]:
    """Held-out error per joint [N m] of the last model with what the rival `name` learns, and its time [s]."""
    start, model = time.monotonic(), diagnosis.model
    train, test = (np.concatenate(rows) for rows in (model.split.train, model.split.test))
    motions = [
        replace(
            each.effect_inputs(model.solution.structure, model.solution.x),
            motion=each.prepared.motion,
            time=each.prepared.time,
        )
        for each in model.split.predictors
    ]
    inputs = np.hstack([np.concatenate([quantity(key, each) for each in motions]) for key in _QUANTITIES])
    inputs = np.nan_to_num((inputs - np.nanmean(inputs, axis=0)) / np.nanstd(inputs, axis=0))
    residual = np.concatenate(model.residuals)
    for joint in diagnosis.unexplained.joints:
        rows = train[:, joint] & np.isfinite(residual[:, joint])
        size = residual[rows, joint].std()
        learned = _regressor(name).fit(inputs[rows], residual[rows, joint] / size)
        residual[:, joint] -= size * np.ravel(learned.predict(inputs))
    return {"after": rms([residual], [test]).tolist(), "seconds": time.monotonic() - start}
