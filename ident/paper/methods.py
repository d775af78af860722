"""Identify by all methods from the same recording and evaluate each on two recordings."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ident.basics import plugins
from ident.data.compatibility import check_same_rig
from ident.data.prepared_recording import PreparedRecording, prepare_all
from ident.estimation import estimators
from ident.estimation.linear_fit import fit
from ident.estimation.problem import Progress
from ident.estimation.regression import Regression
from ident.identification.goodness_of_fit import GoodnessOfFit, goodness_of_fit
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Floats

PAPER: Mapping[str, tuple[float, float, float]] = {
    "pso": (0.9240, 0.9053, 0.9228),
    "rls": (0.8724, 0.8679, 0.8761),
    "dls": (0.8714, 0.8684, 0.8751),
    "svd": (0.8545, 0.8001, 0.8604),
}
"""Table 2 as printed: Eq. (41) of each actuator torque, by method."""
BASELINES = ("rls", "dls", "svd")
FAIR_BASELINE = "ls"
"""Least squares, as of the baselines, on the regressor of the swarm."""
MANUFACTURER = "manufacturer"
NAMES = sorted(
    (name for name in plugins.names("ident.estimation.estimators") if not estimators.declares(name, "NONLINEAR")),
    key=lambda name: ([*PAPER, name].index(name), name),
)
"""Methods for a model that is linear in its parameters, the paper's first."""

ROLES = ("identification", "validation")


@dataclass(frozen=True, eq=False)
class MethodResult:
    """Result of one method: its torque (m, dof) [N m] for both recordings and its goodness of fit."""

    method: str
    parameters: Mapping[str, float]
    torque: tuple[Floats, Floats]
    goodness_of_fit: tuple[GoodnessOfFit, GoodnessOfFit]
    excess: float | None
    """Relative excess over the certified minimum of (33); None for other objectives."""
    diagnostics: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class MethodComparison:
    """Results of all methods."""

    prepared: tuple[PreparedRecording, PreparedRecording]
    """Identification and validation."""
    nominal: tuple[GoodnessOfFit, GoodnessOfFit]
    """Goodness of fit of the manufacturer's model."""
    results: Mapping[str, MethodResult]
    """By method, the paper's first."""

    def baselines_not_below(self, role: int, method: str = "pso") -> list[tuple[str, int]]:
        """Return baselines not below `method` in Eq. (41) on the data of `role`, each with the joint (from 1)."""
        best = self.results[method].goodness_of_fit[role].nrmse
        values_by_method = ((name, self.results[name].goodness_of_fit[role].nrmse) for name in BASELINES)
        return [
            (name, j + 1) for name, values in values_by_method for j, value in enumerate(values) if value >= best[j]
        ]


def compare_methods(
    files: Sequence[Path],
    preprocessing: str,
    seed: int,
    progress: Progress,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
) -> MethodComparison:
    """Identify by every method from the first of two recordings `files`, and evaluate on both.

    settings: by method and name. Swarms run all their iterations, as in the paper, unless these say otherwise.

    Raises:
        BadInput: a recording cannot be used, is of no delta robot, or they are not of the same rig; or a setting is
            not valid.
    """
    of_method = {name: method_settings(name, (settings or {}).get(name, {})) for name in NAMES}
    recordings = [read(path) for path in files]
    check_same_rig(recordings)
    rig = recordings[0].rig
    if rig.mechanism != "delta":
        raise BadInput(
            f"{files[0].name}: a recording of a delta robot expected, {rig.mechanism} found; use `ident fit`"
        )
    forms = {estimators.form(name) for name in NAMES}
    prepared = {form: prepare_all(recordings, preprocessing, None, form) for form in forms}
    results = {}
    for done, name in enumerate(NAMES, start=1):
        results[name] = _result(name, of_method[name], prepared[estimators.form(name)], seed)
        progress(done, len(NAMES))
    first, second = prepared[None]
    # Every delta robot has the nominal torque of Table 1.
    nominal = [goodness_of_fit(each.torque, each.nominal) for each in (first, second) if each.nominal is not None]
    return MethodComparison((first, second), (nominal[0], nominal[1]), results)


def method_settings(name: str, given: Mapping[str, Any]) -> Any:
    """Settings of the method `name`; a swarm runs all its iterations unless `given` says otherwise.

    Raises:
        BadInput: a setting is not valid.
    """
    in_full = {"tolerance": 0.0} if estimators.has_setting(name, "tolerance") else {}
    return estimators.settings(name, {**in_full, **given})


def _result(name: str, settings: Any, prepared: Sequence[PreparedRecording], seed: int) -> MethodResult:
    parameters = prepared[0].mechanism.parameters
    regressions = [Regression.of_mechanism(each) for each in prepared]
    fitted = fit(regressions[:1], parameters, name, settings, np.random.default_rng(seed), lambda *_: None)
    torque = [regression.predicted_torque(fitted.parameters) for regression in regressions]
    agreements = [goodness_of_fit(each.torque, computed) for each, computed in zip(prepared, torque, strict=True)]
    estimate = fitted.estimate
    return MethodResult(
        method=name,
        parameters={
            parameter.name: float(value) for parameter, value in zip(parameters, fitted.parameters, strict=True)
        },
        torque=(torque[0], torque[1]),
        goodness_of_fit=(agreements[0], agreements[1]),
        excess=estimate.certificate.excess(estimate.objective) if estimate.certificate else None,
        diagnostics=estimate.diagnostics,
    )


def as_json(comparison: MethodComparison, preprocessing: str, seed: int) -> dict[str, Any]:
    """Return everything but the curves."""
    return {
        "schema": 1,
        "preprocessing": preprocessing,
        "seed": seed,
        "recordings": dict(zip(ROLES, (each.recording.path.name for each in comparison.prepared), strict=True)),
        "simulated": any(each.recording.run.simulated for each in comparison.prepared),
        "paper": PAPER,
        "nominal": dict(zip(ROLES, map(asdict, comparison.nominal), strict=True)),
        "methods": {
            name: {
                "form": estimators.form(name) or "Eq. (26)",
                "parameters": result.parameters,
                **dict(zip(ROLES, map(asdict, result.goodness_of_fit), strict=True)),
                "excess": result.excess,
                "diagnostics": result.diagnostics,
            }
            for name, result in comparison.results.items()
        },
        "pso_above_baselines": {
            role: not comparison.baselines_not_below(number) for number, role in enumerate(ROLES)
        },
    }
