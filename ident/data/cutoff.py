"""Choose the cut-off of the low-pass from the spectra of position and torque.

Differentiating twice amplifies the noise of the position (mainly encoder quantization) with the square of the
frequency. Multiplied by the inertia, its share of the torque grows with the cut-off to the power of 2.5. The cut-off
is

- high enough to keep most of the torque's power of every joint, and at least DEFAULT_CUTOFF, because friction at
  reversals is broadband; what one joint alone has above it is ripple, which is searched there;
- not above the frequency at which the propagated noise of the position reaches MAX_NOISE_SHARE of the torque;
- not above what the sampling rate permits, including the transition band of the filter;
- below that, where gaps leave hardly a row: what a slow recording of that cut-off would be is interpolated;
- below that, where the noise reaches WANTED_NOISE_SHARE already, if hardly any torque is lost by it. Effects are
  small, and noise attenuates masses and inertias, which the motion tells only just from each other.

Several recordings that are analysed together have one cut-off, the lowest, whatever is asked of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from ident.basics import filters
from ident.basics.filters import contiguous_slices
from ident.basics.statistics import TINY
from ident.basics.threads import in_threads
from ident.data import welch
from ident.data.excerpts import excerpts
from ident.data.samples import Samples, sample
from recordings.errors import BadInput
from recordings.recording import Bools, Floats, Recording

DEFAULT_CUTOFF = 30.0
"""[Hz]"""
MAX_NOISE_SHARE = 0.02
"""Maximum of the position noise propagated to torque, relative to the torque (both RMS within the band)."""
WANTED_NOISE_SHARE = 0.004
"""The same where a lower cut-off loses hardly any torque: the smallest relevant effects are not much larger."""
MIN_BANDWIDTH = 10.0
"""The cut-off is not lowered below this for that, because friction at reversals matters more [Hz]."""
MAX_TORQUE_LOSS = 0.1
"""Largest share of the torque RMS that it may remove: otherwise ripple would be lost."""
POWER_SHARE = 0.95
"""Share of the torque's power to keep."""
MIN_CUTOFF = 1.0
"""[Hz]"""

_RESOLUTION = 0.5
"""Resolution of the spectra [Hz]."""
_EMPTY = 0.35
"""Above this share of the rate, the spectra are assumed to contain only noise."""
_CLEAR = 10.0
"""A spectrum that exceeds the noise by this factor is attributed to the motion."""

_GAP_TIMES_CUTOFF = 0.8
"""Longest gap across which the position is interpolated, times the cut-off: beyond it, more than half a period of the
fastest motion that counts would be guessed."""
_MIN_CLEAR = 0.2
"""Share of rows with no gap within the reach of the filters, below which a lower cut-off, which closes gaps, is
tried."""

Reason = Literal["given", "usual", "signal", "encoder", "rate", "gaps"]


@dataclass(frozen=True)
class Cutoff:
    """Cut-off of a low-pass and the reason for it."""

    hz: float
    reason: Reason
    """given: by the user; usual: DEFAULT_CUTOFF; signal: raised, as the torque has power above DEFAULT_CUTOFF;
    encoder: lowered because of position noise; rate: lowered because of the sampling rate; gaps: lowered so that gaps
    can be interpolated."""
    gap: float = 0.0
    """Longest gap that is interpolated at this cut-off [s], besides two steps of the recording."""

    def sentence(self) -> str:
        """Describe the choice in words."""
        if self.reason == "given":
            return f"{self.hz:g} Hz, as given"
        why = {
            "usual": "the default; neither encoder noise nor sampling rate requires a lower one",
            "signal": "most of the torque's power lies below it",
            "encoder": "above it the position noise would be visible in the torque",
            "rate": "the sampling rate permits no higher one",
            "gaps": f"gaps of up to {self.gap:.2g} s stand so close that no higher one leaves rows between them",
        }
        return f"{self.hz:g} Hz, chosen from the spectra: {why[self.reason]}"


def given_or_chosen(cutoff: "float | Cutoff | None", samples: Samples) -> Cutoff:
    """Return the `cutoff` that is given, in Hz or as chosen for several recordings, or choose one for `samples`.

    Raises:
        BadInput: the given cut-off is not above 0 or exceeds a fifth of the rate.
    """
    if isinstance(cutoff, Cutoff):
        return cutoff
    if cutoff is None:
        return _between_gaps(samples, choose(samples.position, samples.torque, samples.rate))
    if not 0 < cutoff <= samples.rate / 5:
        raise BadInput(
            f"a cut-off above 0 and up to a fifth of the rate ({samples.rate / 5:g} Hz) expected, {cutoff:g} Hz "
            "found; lower it or record faster"
        )
    return _between_gaps(samples, Cutoff(cutoff, "given"))


def choose_common(recordings: Sequence[Recording]) -> Cutoff:
    """Choose one cut-off for all `recordings`: the lowest, each judged by its first excerpt."""

    def chosen(recording: Recording) -> Cutoff:
        return given_or_chosen(None, sample(excerpts(recording)[0].recording))

    cutoffs = in_threads(chosen, recordings)
    return replace(min(cutoffs, key=lambda cutoff: cutoff.hz), gap=max(cutoff.gap for cutoff in cutoffs))


def _between_gaps(samples: Samples, chosen: Cutoff) -> Cutoff:
    """The cut-off `chosen`; where gaps leave hardly a row, the one that keeps most rows times bandwidth.

    It closes the gaps that it can. A cut-off that is given stays.
    """
    known, closing = samples.known, replace(chosen, gap=_GAP_TIMES_CUTOFF / chosen.hz)
    if _clear_share(known, chosen.hz, samples.rate) >= _MIN_CLEAR:
        return chosen
    if chosen.reason == "given":
        return closing
    gaps = [(gap, (gap.stop - gap.start + 1) / samples.rate) for gap in contiguous_slices(~known)]

    def worth(cutoff: Cutoff) -> float:
        closed = known.copy()
        for gap, length in gaps:
            closed[gap] = length <= cutoff.gap
        return cutoff.hz * _clear_share(closed, cutoff.hz, samples.rate)

    lower = [Cutoff(_round_down(_GAP_TIMES_CUTOFF / length), "gaps", length) for length in {at for _, at in gaps}]
    return max([chosen, closing, *(each for each in lower if MIN_CUTOFF <= each.hz < chosen.hz)], key=worth)


def _clear_share(known: Bools, hz: float, rate: float) -> float:
    """Share of the rows `known` (n,) that lie further from a gap than the filters of `parallel` reach."""
    reach = 2 * round(filters.REACH * rate / hz + filters.REACH * rate / min(3 * hz, rate / 4) + 4)
    lengths = (int(stretch.stop - stretch.start) for stretch in contiguous_slices(known))
    return sum(max(0, length - reach) for length in lengths) / len(known)


def choose(position: Floats, torque: Floats, rate: float) -> Cutoff:
    """Choose the cut-off for `position` (n, dof) and `torque` (n, dof) at `rate` [Hz]; the strictest joint rules."""
    joints = spectra(position, torque, rate)
    tolerated = choose_from_spectra(joints, rate)
    wanted = max(choose_from_spectra(joints, rate, WANTED_NOISE_SHARE).hz, MIN_BANDWIDTH)
    if wanted >= tolerated.hz or band_share(torque, rate, wanted, tolerated.hz) > MAX_TORQUE_LOSS:
        return tolerated
    return Cutoff(wanted, "encoder")


def band_share(torque: Floats, rate: float, low: float, high: float) -> float:
    """Share of the RMS of `torque` (n, dof) below `high` that lies above `low` [Hz], of the joint with most."""
    wide, narrow = (filters.convolve(torque, filters.low_pass(hz, rate)) for hz in (high, low))
    share: Floats = np.nanstd(wide - narrow, axis=0) / np.maximum(np.nanstd(wide, axis=0), TINY)
    return float(np.nanmax(share))


def spectra(position: Floats, torque: Floats, rate: float) -> list["Spectra"]:
    """Spectra of `position` (n, dof) and `torque` (n, dof) at `rate` [Hz], of joints with enough gapless data."""
    joints = range(position.shape[1])
    candidates = (Spectra.of(position[:, joint], torque[:, joint], rate) for joint in joints)
    return [spectrum for spectrum in candidates if spectrum is not None]


def choose_from_spectra(joints: Sequence["Spectra"], rate: float, max_noise_share: float = MAX_NOISE_SHARE) -> Cutoff:
    """Choose the cut-off for all `joints` at `rate` [Hz]; `max_noise_share` as in `choose`."""
    # A tenth of the rate, for accurate derivatives; for slow recordings up to a fifth.
    highest = max(rate / 10, min(DEFAULT_CUTOFF, rate / 5))
    wanted = max(DEFAULT_CUTOFF, min((joint.signal_bandwidth() for joint in joints), default=0.0))
    encoder = max(MIN_CUTOFF, min((joint.noise_limit(max_noise_share) for joint in joints), default=np.inf))
    hz = _round_down(min(wanted, encoder, highest))
    if wanted <= min(encoder, highest):
        return Cutoff(hz, "signal" if wanted > DEFAULT_CUTOFF else "usual")
    return Cutoff(hz, "encoder" if encoder < highest else "rate")


@dataclass(frozen=True, eq=False)
class Spectra:
    """Power spectral densities of one joint over frequency (m,), after removal of the mean."""

    frequency: Floats
    """[Hz]"""
    acceleration: Floats
    """[(rad/s^2)^2/Hz]"""
    torque: Floats
    """[(N m)^2/Hz]"""
    cross_spectrum: Floats
    """Real part of the cross-spectral density of torque and acceleration."""
    rate: float
    """[Hz]"""
    averages: int
    """Approximate number of independent spectra that were averaged."""

    @classmethod
    def of(cls, position: Floats, torque: Floats, rate: float) -> "Spectra | None":
        """Estimate the spectra from the longest gapless stretch of `position` (n,) and `torque` (n,).

        Returns None if that stretch is too short.
        """
        gapless = contiguous_slices(np.isfinite(position) & np.isfinite(torque))
        longest = max(gapless, key=lambda stretch: stretch.stop - stretch.start, default=slice(0, 0))
        segment = int(rate / _RESOLUTION)
        acceleration = np.diff(position[longest], 2) * rate**2
        torque = torque[longest][1:-1]
        if len(torque) < segment:
            return None
        averaged = max(1, round(1.5 * len(torque) / segment))
        frequency: Floats = np.fft.rfftfreq(segment, 1 / rate).astype(float)
        transforms = [welch.transforms(signal, segment, centred=True) for signal in (acceleration, torque)]
        acceleration_density, torque_density, common = (
            welch.density(transforms[i], transforms[j], segment, rate) for i, j in ((0, 0), (1, 1), (0, 1))
        )
        # Finite differences attenuate the derivative towards half the rate.
        shortfall: Floats = np.sinc(frequency / rate) ** 2
        return cls(
            frequency,
            acceleration_density / shortfall**2,
            torque_density,
            common / shortfall,
            rate,
            averaged,
        )

    @cached_property
    def position_noise(self) -> float:
        """Density of the position noise, assumed white [rad^2/Hz]."""
        return self._floor(self.acceleration[1:] / self._omega[1:] ** 4)

    @cached_property
    def torque_noise(self) -> float:
        """Density of the torque noise, assumed white [(N m)^2/Hz]."""
        return self._floor(self.torque[1:])

    @cached_property
    def inertia(self) -> float:
        """Approximate inertia [kg m^2]: torque per acceleration where the acceleration clearly exceeds the noise."""
        clear = self.acceleration > _CLEAR * self.position_noise * self._omega**4
        power = self.acceleration[clear].sum()
        return float(abs(self.cross_spectrum[clear].sum()) / power) if power else 0.0

    def signal_bandwidth(self) -> float:
        """Frequency [Hz] below which POWER_SHARE of the torque's power lies, after subtraction of its noise."""
        signal = np.cumsum(np.maximum(self.torque - self.torque_noise, 0.0))
        return float(self.frequency[np.searchsorted(signal, POWER_SHARE * signal[-1])])

    def noise_limit(self, max_noise_share: float = MAX_NOISE_SHARE) -> float:
        """Highest frequency [Hz] at which propagated position noise is below `max_noise_share` of the torque."""
        noise = np.cumsum(self.inertia**2 * self.position_noise * self._omega**4)
        small = noise <= max_noise_share**2 * np.cumsum(self.torque)
        return float(self.frequency[np.flatnonzero(small)[-1]])

    @property
    def _omega(self) -> Floats:
        return 2 * np.pi * self.frequency

    def _floor(self, density: Floats) -> float:
        empty = density[self.frequency[1:] > _EMPTY * self.rate]
        # Ratio of median to mean of the chi-square distribution of averaged spectra (Wilson and Hilferty).
        return float(np.median(empty) / (1 - 1 / (9 * self.averages)) ** 3)


def _round_down(hz: float) -> float:
    """Round down to two significant digits."""
    unit = 10.0 ** (np.floor(np.log10(hz)) - 1)
    return float(np.floor(hz / unit * (1 + 1e-12)) * unit)
