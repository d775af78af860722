"""Ripple and vibrations above the low-pass of the analysis, in their own band beside the dynamics.

A wave over the angle is `cogging`. Its amplitudes and its order are estimated above the low-pass alone, from all
speeds together, and the test rows confirm each wave. The model of the dynamics stays as it is.

At a constant speed, a vibration of fixed frequency is the same. A wave over the angle is certain only if the
recordings contain speeds at which it and every wave over time differ.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np

from ident.basics.statistics import nonzero
from ident.basics.threads import in_threads
from ident.data import cycle_statistics
from ident.data.prepared_recording import PreparedRecording
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import BLOCK_SECONDS, block_means, improvement_of_blocks
from ident.diagnosis.ripple.high_band import HighBand, high_bands
from ident.diagnosis.ripple.ripple_search import SAME_ORDER, search
from ident.diagnosis.ripple.waves import JointSignal, RippleLine, Vibration, least_squares, wave, wave_numbers
from ident.diagnosis.search.selection import Finding, Selection
from ident.diagnosis.split.split_data import rms
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.periodogram import highest_in_band, periodogram
from ident.dynamics.structure import ModelStructure, Term
from recordings.recording import Floats

EFFECT = "cogging"
"""The effect of the library that a wave over the angle is."""
VIBRATION = "vibration"
"""Stands beside the names of effects; no effect of the library."""
_MARGIN = 1.2
"""Ratio of the end of a spectrum, or of the band in which errors are stated, to its highest wave."""


@dataclass(frozen=True, eq=False)
class Ripple:
    """What lies above the low-pass, and what explains it."""

    model: FittedModel
    """The model of the dynamics."""
    bands: tuple[HighBand, ...]
    """Its residual above the low-pass in each recording; empty if the preprocessing keeps no samples there."""
    lines: tuple[RippleLine, ...]
    """The largest improvement first."""
    vibrations: tuple[Vibration, ...]
    effect: Effect | None
    """`cogging`; None if it was not to be searched."""

    @property
    def low(self) -> float:
        """Lower end of the band [Hz]."""
        return self.model.split.recordings[0].bandwidth

    @cached_property
    def upper(self) -> float:
        """End of the band in which errors are stated: the low-pass, or above the highest ripple [Hz]."""
        if not self.lines:
            return self.low
        speeds = np.array([JointSignal(self.bands, joint).speed for joint in range(self.bands[0].residual.shape[1])])
        highest = max(line.order * speeds[line.joint] for line in self.lines) / (2 * np.pi)
        return float(min(_MARGIN * highest, min(band.highest for band in self.bands)))

    @cached_property
    def structure(self) -> ModelStructure:
        """The model structure with a term for each line."""
        structure = self.model.solution.structure
        for line in self.lines:
            assert self.effect is not None  # there are no lines without it
            structure = structure.with_term(Term(EFFECT, self.effect, (line.joint,)))
        return structure

    @cached_property
    def x(self) -> Floats:
        """Parameters of that structure."""
        return np.concatenate([self.model.solution.x, *([line.sine, line.cosine, line.order] for line in self.lines)])

    @cached_property
    def half_widths(self) -> Floats:
        """(3 k,) half the 95 % intervals of the lines' parameters."""
        return np.array([width for line in self.lines for width in line.half_width])

    def errors(self, model: FittedModel, with_lines: bool = False) -> dict[str, Floats]:
        """(dof,) RMS errors of `model` up to the frequency `upper` [N m], as the fields of a step are called.

        with_lines: with the lines above the low-pass. Below it, the error is that of the model alone.
        """
        split = model.split
        subsets = {
            "train_rms": split.train,
            "held_out_rms": split.test,
            "train_rms_all": split.train_all,
            "held_out_rms_all": split.test_all,
        }
        below = {name: rms(model.residuals, rows) for name, rows in subsets.items()}
        if not self.lines:
            return below
        bands = self.bands if model is self.model else high_bands(split, model.solution)
        remaining = self._remaining if with_lines else [band.residual for band in bands]
        residuals = [band.below(rest, self.upper) for band, rest in zip(bands, remaining, strict=True)]
        return {
            name: np.hypot(
                below[name],
                rms(residuals, [band.samples_of(selected) for band, selected in zip(bands, rows, strict=True)]),
            )
            for name, rows in subsets.items()
        }

    def with_noise(self, below: Floats) -> Floats:
        """The noise floor (dof,) up to the frequency `upper` from that `below` the low-pass [N m].

        Above it, noise is what differs between repetitions.
        """
        if not self.lines:
            return below
        residuals = [band.below(rest, self.upper) for band, rest in zip(self.bands, self._remaining, strict=True)]
        pairs = zip(self.model.split.recordings, residuals, strict=True)
        tables = [cycle_statistics.by_cycle(recording.samples, residual) for recording, residual in pairs]
        pooled = cycle_statistics.pooled([each for each in map(cycle_statistics.of_cycles, tables) if each])
        return np.hypot(below, [joint.noise_rms for joint in pooled]) if pooled else below

    @cached_property
    def unexplained_share(self) -> Floats:
        """(dof,) RMS above the low-pass that nothing explains, relative to that of the measured torque."""
        scored = [band.train | band.test for band in self.bands]
        torque = rms([band.prepared.samples.torque for band in self.bands], scored)
        return rms(self._remaining, scored) / nonzero(torque)

    def order_spectrum(self, joint: int, with_lines: bool) -> tuple[Floats, Floats]:
        """Orders (f,) and amplitudes (f,) [N m] of the residual of `joint` above the low-pass, over the angle."""
        residuals = self._remaining if with_lines else [band.residual for band in self.bands]
        signal = JointSignal(
            [replace(band, residual=rest) for band, rest in zip(self.bands, residuals, strict=True)], joint
        )
        highest = max(_MARGIN * line.order for line in self.lines if line.joint == joint)
        orders = wave_numbers(signal.angle[signal.train], highest)
        reduction = periodogram(signal.angle[signal.train], signal.residual[signal.train], orders)
        return orders, np.sqrt(2 * reduction / signal.train.sum())

    @cached_property
    def _remaining(self) -> tuple[Floats, ...]:
        """(n, dof) residual above the low-pass without the lines, of each recording."""
        return tuple(self._without_lines(band) for band in self.bands)

    def _without_lines(self, band: HighBand) -> Floats:
        """(n, dof) residual above the low-pass without the lines."""
        computed = np.zeros_like(band.residual)
        for line in self.lines:
            columns = wave(band.motion.position[:, line.joint], line.order)
            computed[:, line.joint] += columns @ [line.sine, line.cosine]
        return band.residual - (band.above(computed) if self.lines else computed)


def below_low_pass(
    structure: ModelStructure, x: Floats, recordings: Sequence[PreparedRecording]
) -> tuple[ModelStructure, Floats]:
    """A model without the lines that lie above the low-pass: below it nothing determines their amplitudes."""
    for index in reversed(range(len(structure.terms))):
        term = structure.terms[index]
        if term.effect.repeated:
            order = float(structure.shape_values(index, x)[0])
            joints = list(term.joints)
            speeds = np.concatenate([np.abs(each.motion.velocity[:, joints]).ravel() for each in recordings])
            if order > highest_in_band(speeds, recordings[0].bandwidth):
                x = x[~structure.parameter_mask(index)]
                structure = structure.without_term(index)
    return structure, x


def find_ripple(model: FittedModel, library: Mapping[str, Effect]) -> Ripple:
    """Search the residual of `model` above the low-pass for ripple, if the `library` has it, and for vibrations."""
    bands, effect = high_bands(model.split, model.solution), library.get(EFFECT)
    if not bands:
        return Ripple(model, (), (), (), effect)
    steps = np.max([recording.encoder_step for recording in model.split.recordings], axis=0)
    found = in_threads(
        search,
        [JointSignal(bands, joint) for joint in range(len(steps))],
        steps if effect else np.full(len(steps), np.inf),
    )
    lines = [line for each, _ in found for line in each if not _is_known(line, model)]
    lines.sort(key=lambda line: -line.amplitude)
    return Ripple(model, bands, tuple(lines), tuple(chain.from_iterable(each for _, each in found)), effect)


def _is_known(line: RippleLine, model: FittedModel) -> bool:
    """Whether the model has this wave already, at frequencies below the low-pass.

    Above it the amplitude may differ, because the drive answers less.
    """
    structure, x = model.solution.structure, model.solution.x
    orders = [
        float(structure.shape_values(index, x)[0])
        for index, term in enumerate(structure.terms)
        if term.name == EFFECT and line.joint in term.joints
    ]
    return any(abs(line.order - order) < SAME_ORDER * order for order in orders)


def with_vibration_alternatives(selection: Selection) -> Selection:
    """The `selection` with a vibration as an alternative to each ripple that it explains as well."""
    findings = [
        replace(finding, alternatives=(*finding.alternatives, VIBRATION))
        if finding.term.name == EFFECT and not _differs(selection.model, finding)
        else finding
        for finding in selection.findings
    ]
    return replace(selection, findings=tuple(findings))


def _differs(model: FittedModel, finding: Finding) -> bool:
    """Whether the ripple explains more of any joint's residual without it than the best wave over time."""
    index = next(i for i, term in enumerate(model.terms) if term is finding.term)
    order = float(model.solution.structure.shape_values(index, model.solution.x)[0])
    return any(_differs_on_joint(model, finding, order, joint) for joint in finding.term.joints)


def _differs_on_joint(model: FittedModel, finding: Finding, order: float, joint: int) -> bool:
    before: list[Floats] = []
    after: list[Floats] = []
    for number, recording in enumerate(model.split.recordings):
        residual = finding.before.residuals[number][:, joint]
        rows = model.split.scored[number][:, joint] & np.isfinite(residual)
        angle = recording.preprocessed.motion.position[:, joint]
        over_angle = recording.condition(np.where(np.isfinite(angle)[:, None], wave(angle, order), np.nan))
        rows &= np.isfinite(over_angle).all(axis=1)
        if not rows.any():
            continue
        time, signal = recording.time[rows], residual[rows] - residual[rows].mean()
        block = np.floor(time / BLOCK_SECONDS).astype(int)
        for columns, means in (
            (wave(time, _best(time, signal, recording.bandwidth)), before),
            (over_angle[rows], after),
        ):
            rest = signal - columns @ least_squares(columns, signal)
            means.append(block_means(block, rest**2))
    return bool(after) and improvement_of_blocks(np.concatenate(before), np.concatenate(after)).is_supported


def _best(time: Floats, signal: Floats, bandwidth: float) -> float:
    """Angular frequency [rad/s] of the strongest wave over time within the bandwidth."""
    from scipy.optimize import minimize_scalar

    grid = wave_numbers(time, 2 * np.pi * bandwidth)
    if len(grid) < 2:
        return 0.0
    best, step = grid[periodogram(time, signal, grid).argmax()], grid[1] - grid[0]
    bounds = (best - step, best + step)
    refined = minimize_scalar(lambda omega: _rest_square(wave(time, omega), signal), bounds=bounds, method="bounded")
    return float(refined.x)


def _rest_square(columns: Floats, signal: Floats) -> float:
    return float(np.sum((signal - columns @ least_squares(columns, signal)) ** 2))
