"""Which low-pass suits a recording, read from the spectra of its position and torque.

Differentiating twice amplifies the noise of the position (encoder steps, mostly) with the square of the frequency, so
its share of the torque, once multiplied by the inertia, grows with the cut-off to the power of 2.5. The cut-off is

- as high as is needed to keep most of the torque's own power, and USUAL at least: friction at reversals shows
  itself over a wide band;
- no higher than where the propagated noise of the position reaches TOLERATED of the torque;
- no higher than the rate permits, with room for the filter's edge.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from ident.data.samples import Samples
from ident.filters import contiguous_slices
from recordings.errors import BadInput
from recordings.recording import Floats

DEFAULT_CUTOFF = 30.0
"""[Hz]"""
MAX_NOISE_SHARE = 0.02
"""Noise of the position, propagated to torque, over the torque (both RMS within the band)."""
POWER_SHARE = 0.95
"""Share of the torque's power that is to be kept."""
MIN_CUTOFF = 1.0
"""[Hz]"""

_RESOLUTION = 0.5
"""Of the spectra [Hz]."""
_EMPTY = 0.35
"""Above this share of the rate, spectra are taken to hold noise only."""
_CLEAR = 10.0
"""Where a spectrum is so many times the noise, it is the motion's."""

Reason = Literal["given", "usual", "signal", "encoder", "rate"]


@dataclass(frozen=True)
class Cutoff:
    """A low-pass and what decided on it."""

    hz: float
    reason: Reason
    """given: the user; usual: nothing speaks against it; signal: the torque reaches beyond that; encoder: the
    position is too coarse for more; rate: the recording is too slow for more."""

    def sentence(self) -> str:
        """In words."""
        if self.reason == "given":
            return f"{self.hz:g} Hz, as given"
        why = {
            "usual": "the usual one; neither encoder nor rate asks for less",
            "signal": "most of the torque's power lies below",
            "encoder": "above it the noise of the position would show in the torque",
            "rate": "the recording's rate permits no more",
        }
        return f"{self.hz:g} Hz, chosen from the spectra: {why[self.reason]}"


def given_or_chosen(hz: float | None, samples: Samples) -> Cutoff:
    """The cut-off `hz` that the user gave, or the one that suits the `samples`.

    Raises:
        BadInput: the one given is not within reach of the rate.
    """
    if hz is None:
        return choose(samples.position, samples.torque, samples.rate)
    if not 0 < hz <= samples.rate / 5:
        raise BadInput(
            f"a cut-off above 0 and up to a fifth of the rate ({samples.rate / 5:g} Hz) expected, {hz:g} Hz found; "
            "lower it or record faster"
        )
    return Cutoff(hz, "given")


def choose(position: Floats, torque: Floats, rate: float, tolerated: float = MAX_NOISE_SHARE) -> Cutoff:
    """The low-pass for `position` (n, dof) and `torque` (n, dof) at `rate` [Hz]; the strictest joint decides.

    tolerated: propagated noise of the position, over the torque.
    """
    return choose_from_spectra(spectra(position, torque, rate), rate, tolerated)


def spectra(position: Floats, torque: Floats, rate: float) -> list["Spectra"]:
    """Of each joint of `position` (n, dof) and `torque` (n, dof) at `rate` [Hz] that has a long enough stretch."""
    joints = range(position.shape[1])
    found = (Spectra.of(position[:, joint], torque[:, joint], rate) for joint in joints)
    return [one for one in found if one is not None]


def choose_from_spectra(joints: Sequence["Spectra"], rate: float, tolerated: float = MAX_NOISE_SHARE) -> Cutoff:
    """The low-pass that suits all `joints` at `rate` [Hz]; `tolerated` as of `choose`."""
    highest = _permitted(rate)
    wanted = max([DEFAULT_CUTOFF, *(one.signal_bandwidth() for one in joints)])
    encoder = max(MIN_CUTOFF, min((one.noise_limit(tolerated) for one in joints), default=np.inf))
    hz = _round_down(min(wanted, encoder, highest))
    if wanted <= min(encoder, highest):
        return Cutoff(hz, "signal" if wanted > DEFAULT_CUTOFF else "usual")
    return Cutoff(hz, "encoder" if encoder < highest else "rate")


@dataclass(frozen=True, eq=False)
class Spectra:
    """Power spectral densities of one joint over frequency (m,), without its mean."""

    frequency: Floats
    """[Hz]"""
    acceleration: Floats
    """[(rad/s^2)^2/Hz]"""
    torque: Floats
    """[(N m)^2/Hz]"""
    cross_spectrum: Floats
    """Cross spectrum of torque and acceleration, real part."""
    rate: float
    """[Hz]"""
    averages: int
    """Independent spectra, about, whose mean they are."""

    @classmethod
    def of(cls, position: Floats, torque: Floats, rate: float) -> "Spectra | None":
        """Of the longest stretch without a gap of `position` (n,) and `torque` (n,); None if that is too short."""
        from scipy.signal import csd, welch

        known = contiguous_slices(np.isfinite(position) & np.isfinite(torque))
        whole = max(known, key=lambda one: one.stop - one.start, default=slice(0, 0))
        segment = int(rate / _RESOLUTION)
        acceleration = np.diff(position[whole], 2) * rate**2
        torque = torque[whole][1:-1]
        if len(torque) < segment:
            return None
        averaged = max(1, round(1.5 * len(torque) / segment))
        frequency, own = welch(acceleration, rate, nperseg=segment)
        frequency, drive = welch(torque, rate, nperseg=segment)
        _, common = csd(acceleration, torque, rate, nperseg=segment)
        # Differences fall behind the derivative towards half the rate.
        shortfall = np.sinc(frequency / rate) ** 2
        return cls(frequency, own / shortfall**2, drive, np.real(common) / shortfall, rate, averaged)

    @cached_property
    def position_noise(self) -> float:
        """Density of the position's noise, taken to be white [rad^2/Hz]."""
        return self._floor(self.acceleration[1:] / self._omega[1:] ** 4)

    @cached_property
    def torque_noise(self) -> float:
        """Density of the torque's noise, taken to be white [(N m)^2/Hz]."""
        return self._floor(self.torque[1:])

    @cached_property
    def inertia(self) -> float:
        """Torque per acceleration where the acceleration is clear of noise, roughly [kg m^2]."""
        clear = self.acceleration > _CLEAR * self.position_noise * self._omega**4
        power = self.acceleration[clear].sum()
        return float(abs(self.cross_spectrum[clear].sum()) / power) if power else 0.0

    def signal_bandwidth(self) -> float:
        """The frequency [Hz] below which KEPT of the torque's power above its noise lies."""
        signal = np.cumsum(np.maximum(self.torque - self.torque_noise, 0.0))
        return float(self.frequency[np.searchsorted(signal, POWER_SHARE * signal[-1])])

    def noise_limit(self, tolerated: float = MAX_NOISE_SHARE) -> float:
        """The frequency [Hz] up to which the propagated noise of the position stays below what is `tolerated`."""
        noise = np.cumsum(self.inertia**2 * self.position_noise * self._omega**4)
        small = noise <= tolerated**2 * np.cumsum(self.torque)
        return float(self.frequency[np.flatnonzero(small)[-1]])

    @property
    def _omega(self) -> Floats:
        omega: Floats = 2 * np.pi * self.frequency
        return omega

    def _floor(self, density: Floats) -> float:
        empty = density[self.frequency[1:] > _EMPTY * self.rate]
        # The median of the chi-square distribution that averaged spectra have (Wilson and Hilferty), over its mean.
        return float(np.median(empty) / (1 - 1 / (9 * self.averages)) ** 3)


def _permitted(rate: float) -> float:
    """A tenth of the rate, which leaves room for the derivatives; slow recordings must do with a fifth."""
    return max(rate / 10, min(DEFAULT_CUTOFF, rate / 5))


def _round_down(hz: float) -> float:
    """To two digits: a cut-off is no measurement."""
    unit = 10.0 ** (np.floor(np.log10(hz)) - 1)
    return float(np.floor(hz / unit * (1 + 1e-12)) * unit)
