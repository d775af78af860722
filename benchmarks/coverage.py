"""Measure the coverage of the 95 % intervals of `ident fit` on synthetic recordings of Eq. (26).

The motion is taken from a recording of the simulated rig. The torque of Eq. (26) is converted to a voltage, to which
first-order autoregressive noise is added at the full rate. Preprocessing, estimators and intervals are those of
`ident fit`. With a true coverage of 95 %, 93 to 97 % of 1,000 intervals contain the true value.
"""

import os
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import get_args

import numpy as np
from scipy.signal import lfilter
from scipy.stats import norm

from benchmarks.demo import record
from ident.data import noise, preprocessing
from ident.data.prepared_recording import prepare
from ident.data.samples import sample
from ident.dynamics import mechanisms
from ident.estimation import estimators
from ident.estimation.linear_fit import fit
from ident.estimation.regression import Regression
from ident.uncertainty.assessment import loss_of, uncertainty_of
from ident.uncertainty.covariance import IntervalMethod
from recordings.reader import read
from recordings.recording import Floats, Recording

RECORDINGS = 1000
VOLTS = 0.05
"""Standard deviation of the noise [V]; the simulated rig has 0.01 V."""
TRUTH = np.array([4.3963, 5.3480, 0.3823, 0.3237, 0.3047, 0.35, 0.32, 0.38, 9.1037, 7.6127, 9.2628])
"""Eq. (36), friction positive where it opposes motion; viscous friction is dissipative here."""
CUTOFF = 30.0
"""[Hz]"""
INTERVAL_METHODS: tuple[IntervalMethod, ...] = get_args(IntervalMethod)
ACCEPTED_COVERAGE = (0.93, 0.97)


@dataclass(frozen=True)
class Scenario:
    """A kind of noise and the methods that are evaluated with it."""

    correlation: float
    """Correlation time: the autocorrelation falls to 1/e [s]; 0: white noise."""
    methods: tuple[str, ...]

    def draw(self, shape: tuple[int, int], rate: float, generator: np.random.Generator) -> Floats:
        """Noise (n, dof) [V]."""
        rho = np.exp(-1 / (rate * self.correlation)) if self.correlation else 0.0
        settling = int(10 * rate * self.correlation)  # rows until the initial transient has decayed
        white = generator.normal(0.0, VOLTS * np.sqrt(1 - rho**2), (settling + shape[0], shape[1]))
        coloured: Floats = lfilter([1.0], [1.0, -rho], white, axis=0)[settling:]
        return coloured


SCENARIOS = (
    Scenario(0.0, ("ls", "wls")),
    Scenario(0.02, ("ls", "wls", "lad")),
    Scenario(0.1, ("ls", "wls")),
    Scenario(0.4, ("ls", "wls")),
)


@dataclass(frozen=True, eq=False)
class Estimates:
    """Results of one recording."""

    errors: Floats
    """(methods, k) estimate minus true value."""
    half_widths: Floats
    """(methods, interval methods, k) half-widths of the intervals."""


class NoisyRecordings:
    """Creates recordings of one motion with different noise, and fits them."""

    def __init__(self, measured: Recording) -> None:
        """Take the motion from `measured`."""
        samples = sample(measured)
        mechanism = mechanisms.create(measured.rig)
        motion = preprocessing.load("parallel")(samples, CUTOFF).motion
        torque = mechanism.regressor(motion) @ TRUTH
        self.voltage = np.sign(torque) * np.sqrt(np.abs(torque) / measured.rig.torque.gain)
        self.exact = replace(measured, voltage=self.voltage)
        self.prepared = prepare(self.exact, "parallel", CUTOFF)

    def with_noise(self, volts: Floats) -> Regression:
        """Regression of a recording with the noise `volts` (n, dof); its positions, thus its regressor, stay."""
        noisy = replace(self.exact, voltage=self.voltage + volts)
        preprocessed = preprocessing.load("parallel")(sample(noisy), CUTOFF)
        torque = np.where(self.prepared.usable, preprocessed.torque, np.nan)
        prepared = replace(self.prepared, recording=noisy, preprocessed=preprocessed, torque=torque)
        return Regression.of_mechanism(prepared)

    def estimates_of(self, scenario: Scenario, seed: int) -> Estimates:
        """Estimates and intervals of one recording with random noise."""
        generator = np.random.default_rng([seed, round(1e3 * scenario.correlation)])
        rate = self.exact.run.rate
        regression = self.with_noise(scenario.draw(self.voltage.shape, rate, generator))
        results = [self._fit_method(regression, method) for method in scenario.methods]
        return Estimates(*(np.stack(arrays) for arrays in zip(*results, strict=True)))

    def _fit_method(self, regression: Regression, method: str) -> tuple[Floats, Floats]:
        settings = estimators.settings(method, {})
        parameters = self.prepared.mechanism.parameters
        result = fit([regression], parameters, method, settings, np.random.default_rng(0), lambda *_: None)
        residual = regression.residual(result.parameters)
        spectrum, loss = noise.estimate([regression.prepared], [residual]), loss_of(result, method)
        free = np.ones(len(TRUTH), bool)
        widths = [
            uncertainty_of([regression], [residual], spectrum, loss, interval_method, free).half_width()
            for interval_method in INTERVAL_METHODS
        ]
        return result.parameters - TRUTH, np.stack(widths)


@dataclass(frozen=True, eq=False)
class Coverage:
    """Statistics over many recordings."""

    scenario: Scenario
    share: Floats
    """(methods, interval methods, k) share of the intervals that contain the true value."""
    width: Floats
    """(methods, interval methods, k) mean width relative to an interval from the actual spread of the errors."""

    @classmethod
    def of(cls, scenario: Scenario, estimates: Sequence[Estimates]) -> "Coverage":
        """Coverage and width of the `estimates` of one scenario."""
        errors = np.stack([estimate.errors for estimate in estimates])[:, :, None]
        half_widths = np.stack([estimate.half_widths for estimate in estimates])
        ideal = norm.ppf(0.975) * errors.std(axis=0)
        return cls(scenario, (np.abs(errors) <= half_widths).mean(axis=0), half_widths.mean(axis=0) / ideal)

    def lines(self, names: Sequence[str]) -> Iterator[str]:
        """Lines of a table with one row per parameter."""
        methods = self.scenario.methods
        columns = [(i, j) for i in range(len(methods)) for j in range(len(INTERVAL_METHODS))]
        time = f"{1e3 * self.scenario.correlation:g} ms" if self.scenario.correlation else "none (white)"
        yield f"noise in the voltage, correlation time {time}: coverage in %"
        yield f"{'':6}" + "".join(f"{methods[i] + ' ' + INTERVAL_METHODS[j]:>16}" for i, j in columns)
        for k, name in enumerate(names):
            yield f"{name:6}" + "".join(f"{100 * self.share[i, j, k]:16.1f}" for i, j in columns)
        yield f"{'width':6}" + "".join(f"{self.width[i, j].mean():16.2f}" for i, j in columns)
        inside = [
            bool(((self.share[i, j] >= ACCEPTED_COVERAGE[0]) & (self.share[i, j] <= ACCEPTED_COVERAGE[1])).all())
            for i, j in columns
        ]
        yield f"{'93-97':6}" + "".join(f"{'all' if accepted else 'not all':>16}" for accepted in inside)


_noisy_recordings: NoisyRecordings | None = None


def _initialize_worker(path: Path) -> None:
    global _noisy_recordings
    _noisy_recordings = NoisyRecordings(read(path))


def _run_seed(scenario: Scenario, seed: int) -> Estimates:
    assert _noisy_recordings is not None
    return _noisy_recordings.estimates_of(scenario, seed)


def main() -> None:
    """Print a table for each kind of noise."""
    # One process per core: multithreaded libraries would compete for the cores.
    os.environ.update({f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL")})
    with tempfile.TemporaryDirectory() as folder:
        (path,) = record(Path(folder), "fig5a")
        names = [parameter.name for parameter in mechanisms.create(read(path).rig).parameters]
        with ProcessPoolExecutor(
            mp_context=get_context("spawn"), initializer=_initialize_worker, initargs=(path,)
        ) as pool:
            print(f"{RECORDINGS} recordings for each kind of noise; width: relative to the actual spread of errors")
            for scenario in SCENARIOS:
                estimates = list(pool.map(partial(_run_seed, scenario), range(RECORDINGS), chunksize=25))
                print("\n".join(Coverage.of(scenario, estimates).lines(names)), flush=True)


if __name__ == "__main__":
    main()
