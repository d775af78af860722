"""All methods on the same two recordings, each judged on both."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ident import plugins
from ident.data.compatibility import check_same_rig
from ident.data.dataset import Dataset, build_all
from ident.dynamics import mechanisms
from ident.estimation import estimators
from ident.estimation.linear_fit import fit
from ident.estimation.problem import Progress
from ident.identification.goodness_of_fit import Fitness, fitness
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
"""The baselines' least squares on the regressor of the swarm."""
MANUFACTURER = "manufacturer"

ROLES = ("identification", "validation")


@dataclass(frozen=True, eq=False)
class MethodResult:
    """One method: its torque (m, dof) [N m] for both recordings, and how well that agrees."""

    method: str
    parameters: Mapping[str, float]
    torque: tuple[Floats, Floats]
    fitness: tuple[Fitness, Fitness]
    excess: float | None
    """Above the certified minimum of (33), relative, where that is the method's objective."""
    diagnostics: Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class MethodComparison:
    """All methods side by side."""

    datasets: tuple[Dataset, Dataset]
    """Identification and validation."""
    nominal: tuple[Fitness, Fitness]
    """The manufacturer's model."""
    results: Mapping[str, MethodResult]
    """By method, the paper's first."""

    def baselines_not_below(self, role: int, method: str = "pso") -> list[tuple[str, int]]:
        """Baselines that are not below `method` in Eq. (41) on the data of `role`, each with the joint (from 1)."""
        best = self.results[method].fitness[role].nrmse
        found = ((name, self.results[name].fitness[role].nrmse) for name in BASELINES)
        return [(name, j + 1) for name, values in found for j, value in enumerate(values) if value >= best[j]]


def compare_methods(files: Sequence[Path], preprocessing: str, seed: int, progress: Progress) -> MethodComparison:
    """Identify by every method on the first of two recordings `files`, and judge on both.

    Swarms run all their iterations, as in the paper.

    Raises:
        BadInput: a recording cannot be used, is of no delta robot, or they are not of the same rig.
    """
    recordings = [read(path) for path in files]
    check_same_rig(recordings)
    rig = recordings[0].rig
    if rig.mechanism != "delta":
        raise BadInput(
            f"{files[0].name}: a recording of a delta robot expected, {rig.mechanism} found; use `ident fit`"
        )
    names = sorted(plugins.names("ident.estimation.estimators"), key=lambda name: ([*PAPER, name].index(name), name))
    forms = {form: mechanisms.create(rig, form) for form in {estimators.form(name) for name in names}}
    datasets = {form: build_all(recordings, mechanism, preprocessing, None) for form, mechanism in forms.items()}
    results = {}
    for done, name in enumerate(names, start=1):
        form = estimators.form(name)
        results[name] = _result(name, forms[form], datasets[form], seed)
        progress(done, len(names))
    own = datasets[None]
    nominal = [fitness(dataset.torque, _known(dataset.nominal)) for dataset in own]
    return MethodComparison((own[0], own[1]), (nominal[0], nominal[1]), results)


def _result(name: str, mechanism: mechanisms.Mechanism, datasets: Sequence[Dataset], seed: int) -> MethodResult:
    given = {"tolerance": 0.0} if estimators.has_setting(name, "tolerance") else {}
    settings = estimators.settings(name, given)
    found = fit(datasets[:1], mechanism, name, settings, np.random.default_rng(seed), lambda *_: None)
    torque = [found.torque(dataset) for dataset in datasets]
    judged = [fitness(dataset.torque, own) for dataset, own in zip(datasets, torque, strict=True)]
    estimate = found.estimate
    return MethodResult(
        method=name,
        parameters={
            one.name: float(value) for one, value in zip(mechanism.parameters, found.parameters, strict=True)
        },
        torque=(torque[0], torque[1]),
        fitness=(judged[0], judged[1]),
        excess=estimate.certificate.excess(estimate.objective) if estimate.certificate else None,
        diagnostics=estimate.diagnostics,
    )


def _known(nominal: Floats | None) -> Floats:
    assert nominal is not None, "a delta robot has Table 1"
    return nominal


def as_json(comparison: MethodComparison, preprocessing: str, seed: int) -> dict[str, Any]:
    """Everything but the curves."""
    return {
        "schema": 1,
        "preprocessing": preprocessing,
        "seed": seed,
        "recordings": dict(zip(ROLES, (dataset.recording.path.name for dataset in comparison.datasets), strict=True)),
        "simulated": any(dataset.recording.run.simulated for dataset in comparison.datasets),
        "paper": PAPER,
        "nominal": dict(zip(ROLES, map(asdict, comparison.nominal), strict=True)),
        "methods": {name: _method_as_json(result) for name, result in comparison.results.items()},
        "pso_above_baselines": {
            role: not comparison.baselines_not_below(number) for number, role in enumerate(ROLES)
        },
    }


def _method_as_json(result: MethodResult) -> dict[str, Any]:
    return {
        "form": estimators.form(result.method) or "Eq. (26)",
        "parameters": result.parameters,
        **dict(zip(ROLES, map(asdict, result.fitness), strict=True)),
        "excess": result.excess,
        "diagnostics": result.diagnostics,
    }
