"""Ripple and vibrations above the low-pass of the analysis, in their own band beside the dynamics.

A wave over the angle is `cogging`. Its amplitudes and its order are estimated above the low-pass alone, from all
speeds together, and the test rows confirm each wave. The model of the dynamics stays as it is; the waves act below
the low-pass as well.

At a constant speed, a vibration of fixed frequency is the same. A wave over the angle is certain only if the
recordings contain speeds at which it and every wave over time differ.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain

import numpy as np

from ident.basics.statistics import nonzero
from ident.basics.threads import in_threads
from ident.data import cycle_statistics
from ident.data.prepared_recording import PreparedRecording
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.judge import Evidence, evidence_of
from ident.diagnosis.ripple.high_band import HighBand, high_bands
from ident.diagnosis.ripple.ripple_line import BAND_MARGIN, BandEvidence, RippleLine
from ident.diagnosis.ripple.ripple_search import SAME_ORDER, estimated_order, search
from ident.diagnosis.ripple.waves import JointSignal, Vibration, wave, wave_numbers
from ident.diagnosis.split.split_data import rms
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.periodogram import highest_in_band, periodogram
from ident.dynamics.structure import ModelStructure, Term
from recordings.pickling import WithoutCaches
from recordings.recording import Floats

EFFECT = "cogging"
"""The effect of the library that a wave over the angle is."""


@dataclass(frozen=True, eq=False)
class Ripple(WithoutCaches):
    """What lies above the low-pass, and what explains it."""

    model: FittedModel
    """The model of the dynamics."""
    bands: tuple[HighBand, ...] = ()
    """Its residual above the low-pass in each recording; empty if the preprocessing keeps no samples there."""
    lines: tuple[RippleLine, ...] = ()
    """The largest improvement first."""
    vibrations: tuple[Vibration, ...] = ()
    effect: Effect | None = None
    """`cogging`; None if it was not to be searched."""
    known_orders: Mapping[int, Sequence[float]] = field(default_factory=dict)
    """Ends of the intervals above the low-pass of orders that the model has already, by their index in its `x`."""

    @property
    def low(self) -> float:
        """Lower end of the band [Hz]."""
        return self.model.split.recordings[0].bandwidth

    @cached_property
    def upper(self) -> float:
        """End of the band in which errors are stated: the low-pass, or above the highest ripple [Hz]."""
        return max((line.evidence.band[1] for line in self.lines), default=self.low)

    @cached_property
    def evidence(self) -> Evidence:
        """The record of the strongest of the lines, with the errors (dof,) of all joints in its band.

        A joint that ripples has those of its own strongest line, in that line's band.
        """
        strongest = self.lines[0].evidence
        others = rms(self._within(self._remaining, strongest.band), [band.test for band in self.bands])
        before, after = others.tolist(), others.tolist()
        for line in reversed(self.lines):
            before[line.joint], after[line.joint] = line.evidence.before, line.evidence.after
        return replace(
            evidence_of(strongest.improvement),
            band_hz=strongest.band,
            rms_before=tuple(before),
            rms_after=tuple(after),
        )

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
    def whole(self) -> FittedModel:
        """The model with its lines, which act below the low-pass as well; no fit, as little of them is left there."""
        solution = replace(self.model.solution, structure=self.structure, x=self.x)
        return FittedModel(self.model.split, solution) if self.lines else self.model

    @cached_property
    def half_widths(self) -> Floats:
        """(3 k,) half the 95 % intervals of the lines' parameters."""
        return np.array([width for line in self.lines for width in line.half_width])

    def intervals(self, model: FittedModel) -> Floats:
        """(K, 2) 95 % intervals of the parameters of `model` for an exactly known torque gain.

        What a drive delays, or another wave, shifts an order, which is then not the same below the low-pass and above
        it: the interval of an order of the last model reaches from one to the other.
        """
        intervals = model.shape_intervals.copy()
        for index, orders in self.known_orders.items() if model is self.model else ():
            intervals[index] = min(intervals[index, 0], *orders), max(intervals[index, 1], *orders)
        return intervals

    def errors(self, model: FittedModel, with_lines: bool = False) -> dict[str, Floats]:
        """(dof,) RMS errors of `model` up to the frequency `upper` [N m], as the fields of a step are called.

        with_lines: of the `whole` model in its place.
        """
        split, residuals = model.split, (self.whole if with_lines else model).residuals
        subsets = {
            "train_rms": split.train,
            "held_out_rms": split.test,
            "train_rms_all": split.train_all,
            "held_out_rms_all": split.test_all,
        }
        below = {name: rms(residuals, rows) for name, rows in subsets.items()}
        if not self.lines:
            return below
        bands = self.bands if model is self.model else high_bands(split, model.solution)
        remaining = self._remaining if with_lines else [band.residual for band in bands]
        above = self._within(remaining, (self.low, self.upper))
        return {
            name: np.hypot(
                below[name],
                rms(above, [band.samples_of(selected) for band, selected in zip(bands, rows, strict=True)]),
            )
            for name, rows in subsets.items()
        }

    def with_noise(self, below: Floats) -> Floats:
        """The noise floor (dof,) up to the frequency `upper` from that `below` the low-pass [N m].

        Above it, noise is what differs between repetitions; where nothing repeats, it goes on as white.
        """
        if not self.lines:
            return below
        samples = [band.prepared.samples for band in self.bands]
        statistics = cycle_statistics.of_residuals(samples, self._within(self._remaining, (self.low, self.upper)))
        above = (
            [joint.noise_rms for joint in statistics] if statistics else below * np.sqrt(self.upper / self.low - 1)
        )
        return np.hypot(below, above)

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
        highest = max(BAND_MARGIN * line.order for line in self.lines if line.joint == joint)
        orders = wave_numbers(signal.angle[signal.train], highest)
        reduction = periodogram(signal.angle[signal.train], signal.residual[signal.train], orders)
        return orders, np.sqrt(2 * reduction / signal.train.sum())

    def _within(self, residuals: Sequence[Floats], band: tuple[float, float]) -> list[Floats]:
        """The part of the `residuals` (n, dof) above the low-pass between two frequencies [Hz]."""
        return [each.within(rest, *band) for each, rest in zip(self.bands, residuals, strict=True)]

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
        return Ripple(model)
    steps = np.max([recording.encoder_step for recording in model.split.recordings], axis=0)
    found = in_threads(
        search,
        [JointSignal(bands, joint) for joint in range(len(steps))],
        steps if effect else np.full(len(steps), np.inf),
    )
    new = (line for each, _ in found for line in each if not _is_known(line, model))
    return Ripple(
        model,
        bands,
        tuple(sorted(new, key=lambda line: -line.evidence.improvement.share)),
        tuple(chain.from_iterable(vibrations for _, vibrations in found)),
        effect,
        _known_orders(model, bands),
    )


def _is_known(line: RippleLine, model: FittedModel) -> bool:
    """Whether the model has this wave already, at frequencies below the low-pass.

    Above it the amplitude may differ, because the drive answers less.
    """
    known = (order for joint, order, *_ in _waves(model) if joint == line.joint)
    return any(abs(line.order - order) < SAME_ORDER * order for order in known)


def _waves(model: FittedModel) -> Iterator[tuple[int, float, Floats, int]]:
    """Joint (from 0), order, amplitudes (2,) of sine and cosine of each wave of `model`, and its index in `x`."""
    structure, x = model.solution.structure, model.solution.x
    for index, term in enumerate(structure.terms):
        if term.name == EFFECT:
            (parameter,) = np.flatnonzero(structure.parameter_mask(index) & ~structure.linear).tolist()
            pairs = zip(term.joints, structure.local_values(index, x), strict=True)
            yield from ((joint, float(x[parameter]), amplitudes, parameter) for joint, amplitudes in pairs)


def _known_orders(model: FittedModel, bands: Sequence[HighBand]) -> dict[int, list[float]]:
    """The ends of the intervals in which the orders of `model` lie above the low-pass, by the index of each in `x`.

    Only of waves that pay there, too.
    """
    orders: dict[int, list[float]] = {}
    for joint, order, amplitudes, parameter in _waves(model):
        signal = JointSignal(bands, joint)
        if not signal.speed:
            continue
        carrier = signal.over_angle()
        residual = signal.residual + signal.above(wave(np.nan_to_num(signal.angle), order)) @ amplitudes
        left = residual - carrier.fitted(carrier.columns(order), residual)
        if BandEvidence.of(signal, order, (residual, left), (residual, left)).pays:
            above, half_width = estimated_order(carrier, order, residual)
            orders.setdefault(parameter, []).extend((above - half_width, above + half_width))
    return orders
