"""Remarks 1 and 2 of the paper, measured: swarms of several sizes and many seeds, cyclic beside classical."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ident.estimation.linear_fit import fit
from ident.estimation.problem import Progress
from ident.estimation.regression import Regression
from ident.identification.goodness_of_fit import goodness_of_fit
from ident.paper.methods import MethodComparison, method_settings
from recordings.recording import Floats

TOPOLOGIES = ("pso", "pso_classic")
"""The swarm with the cyclic neighbourhood, and that of Appendix C."""
TARGETS = (1e-3, 1e-6)
"""Relative excess over the certified minimum of (33) that counts as near it, and as reached."""


@dataclass(frozen=True, eq=False)
class SwarmRun:
    """One swarm."""

    seed: int
    excess: Floats
    """(iterations + 1,) relative excess over the certified minimum of (33)."""
    spread: Floats
    """(iterations + 1,) of the particles, see `ident.estimation.problem.Estimate`."""
    parameters: Floats
    """(k,)"""
    nrmse: tuple[float, ...]
    """Eq. (41) of each joint on validation data."""

    def iterations_to(self, target: float) -> int | None:
        """Number of iterations after which the excess is at most `target`; None: never."""
        reached = self.excess <= target
        return int(reached.argmax()) if reached.any() else None


@dataclass(frozen=True, eq=False)
class SwarmGroup:
    """Swarms that differ only in their seeds."""

    method: str
    particles: int
    neighbours: int | None
    """None: the whole swarm."""
    runs: tuple[SwarmRun, ...]

    @property
    def excess(self) -> Floats:
        """(runs,) final excess."""
        return np.array([run.excess[-1] for run in self.runs])

    def reached(self, target: float) -> list[int]:
        """Numbers of iterations to the `target`, of the runs that reach it."""
        return [steps for run in self.runs if (steps := run.iterations_to(target)) is not None]

    @property
    def nrmse_range(self) -> float:
        """Largest difference of Eq. (41) between two seeds, on any joint."""
        return float(np.ptp([run.nrmse for run in self.runs], axis=0).max())

    @property
    def parameter_range(self) -> float:
        """Largest difference of a parameter between two seeds, relative to its median."""
        values = np.array([run.parameters for run in self.runs])
        return float((np.ptp(values, axis=0) / np.abs(np.median(values, axis=0))).max())


@dataclass(frozen=True, eq=False)
class SwarmStudy:
    """All groups, by size and then method."""

    groups: tuple[SwarmGroup, ...]
    parameter_names: tuple[str, ...]
    source: str
    """Name of the recording that was fitted, and whether it is simulated."""

    def group(self, method: str, particles: int) -> SwarmGroup:
        """Group of `method` with this number of particles."""
        return next(each for each in self.groups if (each.method, each.particles) == (method, particles))

    @property
    def sizes(self) -> list[int]:
        """Numbers of particles, in the given order."""
        return list(dict.fromkeys(group.particles for group in self.groups))


def study_swarms(
    comparison: MethodComparison,
    seeds: Sequence[int],
    sizes: Sequence[int],
    settings: Mapping[str, Mapping[str, Any]],
    progress: Progress,
) -> SwarmStudy:
    """Run cyclic and classical swarms of all `sizes` from all `seeds` on the recordings of `comparison`.

    settings: by method and name. The number of neighbours is that share of the swarm that it is in them.

    Raises:
        BadInput: a setting is not valid.
    """
    train, validation = (Regression.of_mechanism(each) for each in comparison.prepared)
    parameters = comparison.prepared[0].mechanism.parameters
    planned = [_settings(method, size, settings.get(method, {})) for size in sizes for method in TOPOLOGIES]
    groups: list[SwarmGroup] = []
    total = len(planned) * len(seeds)
    for method, chosen in zip(TOPOLOGIES * len(sizes), planned, strict=True):
        runs = []
        for seed in seeds:
            fitted = fit([train], parameters, method, chosen, np.random.default_rng(seed), lambda *_: None)
            estimate = fitted.estimate
            assert estimate.certificate is not None
            assert estimate.spread is not None
            predicted = validation.predicted_torque(fitted.parameters)
            runs.append(
                SwarmRun(
                    seed,
                    np.array([estimate.certificate.excess(value) for value in estimate.history]),
                    estimate.spread,
                    fitted.parameters,
                    goodness_of_fit(validation.torque, predicted).nrmse,
                )
            )
            progress(len(groups) * len(seeds) + len(runs), total)
        groups.append(SwarmGroup(method, chosen.particles, getattr(chosen, "neighbours", None), tuple(runs)))
    recording = comparison.prepared[0].recording
    source = f"{recording.path.name}{', SIMULATED' if recording.run.simulated else ''}"
    return SwarmStudy(tuple(groups), tuple(parameter.name for parameter in parameters), source)


def _settings(method: str, particles: int, given: Mapping[str, Any]) -> Any:
    """Settings of `method` for a swarm of `particles`, with the same share of neighbours as in those `given`."""
    chosen = method_settings(method, given)
    changes = {"particles": particles}
    if hasattr(chosen, "neighbours"):
        changes["neighbours"] = max(2, 2 * round(particles * chosen.neighbours / chosen.particles / 2))
    return replace(chosen, **changes)


def as_json(study: SwarmStudy) -> list[dict[str, Any]]:
    """Return the figures of each group."""
    return [
        {
            "method": group.method,
            "particles": group.particles,
            "neighbours": group.neighbours,
            "seeds": [run.seed for run in group.runs],
            "excess": {"median": float(np.median(group.excess)), "worst": float(group.excess.max())},
            "iterations_to": {
                f"{target:g}": {"reached": len(steps), "median": float(np.median(steps)) if steps else None}
                for target in TARGETS
                if (steps := group.reached(target)) is not None
            },
            "nrmse_range": group.nrmse_range,
            "parameter_range": group.parameter_range,
        }
        for group in study.groups
    ]
