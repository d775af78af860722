"""Other signs and orders of the joints, and how well the mechanism explains the torque with them."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, permutations, product

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from recordings.errors import BadInput
from recordings.recording import Floats

BAD = 0.25
"""Error of the present arrangement, as a share of the torque, from which on it is bad; where it is smaller, the other
one has to be better still, in proportion."""
MAX_OTHER = 0.4
"""Another arrangement is far better if its error is smaller than this share of the present one's."""
_MAX_PERMUTED = 3
"""With more joints, only exchanges of two and single signs are tried."""


@dataclass(frozen=True)
class Arrangement:
    """Which torque belongs to each joint."""

    order: tuple[int, ...]
    """(dof,) number of the torque, from 0, of each joint."""
    signs: tuple[int, ...]
    """(dof,) 1, or -1 where the torque has the other sign."""

    @property
    def moved(self) -> tuple[int, ...]:
        """Joints, from 0, with the torque of another one."""
        return tuple(joint for joint, other in enumerate(self.order) if joint != other)

    @property
    def turned(self) -> tuple[int, ...]:
        """Joints, from 0, whose torque has the other sign."""
        return tuple(joint for joint, sign in enumerate(self.signs) if sign < 0)


class Arrangements:
    """Fits of the mechanism without effects to rows of recordings, in each arrangement of the joints."""

    def __init__(self, recordings: Sequence[PreparedRecording]) -> None:
        self._parameters = recordings[0].mechanism.parameters
        self._dof = recordings[0].torque.shape[1]
        rows = [(each.regressor[known], each.torque[known]) for each in recordings if (known := _known(each)).any()]
        self._gram = sum((np.einsum("njk,njl->kl", columns, columns) for columns, _ in rows))
        self._products = sum((np.einsum("njk,ni->jik", columns, torque) for columns, torque in rows))
        """(dof, dof, k) of the columns of each joint with the torque of each."""
        self._square = float(sum((torque**2).sum() for _, torque in rows))

    @cached_property
    def parameters(self) -> Floats:
        """(k,) of the mechanism in the present arrangement, by least squares."""
        return np.linalg.lstsq(self._gram, np.einsum("jjk->k", self._products), rcond=_TINY)[0]

    @cached_property
    def _roots(self) -> tuple[Floats, Floats]:
        """Roots (r,) of the eigenvalues of the normal equations, and their vectors (k, r); none that vanishes."""
        values, vectors = np.linalg.eigh(self._gram)
        kept = values > _TINY * values[-1]
        return np.sqrt(values[kept]), vectors[:, kept]

    @cached_property
    def best(self) -> tuple[Arrangement, float, float] | None:
        """The arrangement that explains the torque far better than the present one, and the errors of this and that,
        as shares of the torque; None where there is none."""
        if not self._square:
            return None
        present = self.present
        limit = MAX_OTHER * present * min(present / BAD, 1.0)
        hopeful = [each for each in self._others() if self._error(each, bounded=False) < limit]
        errors = {each: self._error(each) for each in hopeful}
        best = min(errors, key=lambda each: errors[each], default=None)
        return None if best is None or errors[best] > limit else (best, present, errors[best])

    @property
    def present(self) -> float:
        """RMS error of the present arrangement, as a share of the torque."""
        return self._error(self._in_place)

    @property
    def _in_place(self) -> Arrangement:
        return Arrangement(tuple(range(self._dof)), (1,) * self._dof)

    def _others(self) -> Iterator[Arrangement]:
        joints = range(self._dof)
        if self._dof <= _MAX_PERMUTED:
            yield from (
                Arrangement(order, signs)
                for order in permutations(joints)
                for signs in product((1, -1), repeat=self._dof)
            )
            return
        for first, second in combinations(joints, 2):
            exchange = {first: second, second: first}
            yield Arrangement(tuple(exchange.get(j, j) for j in joints), (1,) * self._dof)
        yield from (Arrangement(tuple(joints), tuple(-1 if j == turned else 1 for j in joints)) for turned in joints)

    def _error(self, arrangement: Arrangement, *, bounded: bool = True) -> float:
        """RMS error as a share of the torque, with the parameters that are physically positive `bounded`."""
        from scipy.optimize import lsq_linear

        b = np.array(arrangement.signs) @ self._products[np.arange(self._dof), list(arrangement.order)]
        # Least squares with these normal equations: |L' x - L^-1 b|^2 + |torque|^2 - |L^-1 b|^2.
        size, vectors = self._roots
        root, target = size[:, None] * vectors.T, (vectors.T @ b) / size
        rest = max(self._square - float(target @ target), 0.0)
        if bounded:
            lower = [0.0 if parameter.physically_positive else -np.inf for parameter in self._parameters]
            rest += 2 * float(lsq_linear(root, target, (lower, np.inf)).cost)
        return float(np.sqrt(rest / self._square))


_TINY = 1e-12


def error_of(prepared: Iterable[PreparedRecording]) -> float:
    """RMS error of the present arrangement, as a share of the torque.

    prepared: recordings as they are being prepared; infinite where the mechanism cannot be assembled at their angles.
    """
    try:
        return Arrangements([*prepared]).present
    except BadInput:
        return np.inf


def _known(recording: PreparedRecording) -> np.ndarray:
    """(m,) rows with the torque of all joints."""
    return np.asarray(recording.usable.all(axis=1) & np.isfinite(recording.regressor).all(axis=(1, 2)))
