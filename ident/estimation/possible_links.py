"""Least squares in which the links of a tree stay bodies, and whether a motion speaks for that."""

from collections.abc import Sequence

import numpy as np

from ident.basics.statistics import nonzero, solve_normal
from ident.data.prepared_recording import PreparedRecording
from ident.dynamics.mechanisms.urdf import Urdf
from recordings.recording import Bools, Floats

_BLOCKS = 5
"""Parts of each recording, of which each is predicted by the others."""
_ROUNDING = 1e-12
"""Share of the largest eigenvalue below which a direction is not in the data."""


def step(links: Urdf, gram: Floats, product: Floats, now: Floats) -> Floats:
    """(f,) least-squares step after which the base parameters, `now` (b,) and the first of the step, are of bodies.

    gram, product: (f, f) and (f,) of the derivatives by all parameters, with themselves and with the residual.
    """
    size, b = nonzero(np.sqrt(np.diag(gram))), len(now)
    scaled, right = gram / np.outer(size, size), product / size
    # What the others make of the base parameters' columns and of the residual.
    others = np.linalg.lstsq(scaled[b:, b:], np.column_stack([scaled[b:, :b], right[b:]]), rcond=_ROUNDING)[0]
    values, vectors = np.linalg.eigh(scaled[:b, :b] - scaled[:b, b:] @ others[:, :b])
    kept = values > _ROUNDING * values[-1]
    length = np.sqrt(values[kept])
    root = length[:, None] * vectors[:, kept].T * size[:b]
    target = vectors[:, kept].T @ (right[:b] - scaled[:b, b:] @ others[:, b]) / length
    base = links.base.combination @ links.nearest_bodies(root, target + root @ now) - now
    return np.concatenate([base, (others[:, b] - others[:, :b] @ (base * size[:b])) / size[b:]])


def bound_to_bodies(
    recordings: Sequence[PreparedRecording], train: Sequence[Bools], weights: Sequence[Floats]
) -> tuple[PreparedRecording, ...]:
    """Return the `recordings`, with links that stay bodies if the rows `train` (m, dof) speak for that.

    A poor motion leaves combinations of base parameters to noise and to what the model lacks, and another motion then
    shows them. Bodies bound them; but where gains or lengths of the rig file are wrong, no bodies move like that.
    Each block of the rows is predicted from the others, with and without the bound: the smaller error decides.

    weights: (m, dof) 1 / standard deviation of each row.
    """
    if not isinstance(links := recordings[0].mechanism, Urdf):
        return tuple(recordings)
    blocks = [block for each in zip(recordings, train, weights, strict=True) for block in _blocks(*each)]
    b, error = len(links.base.columns), np.zeros(2)
    for left_out, block in enumerate(blocks):
        rest = np.sum(blocks[:left_out] + blocks[left_out + 1 :], axis=0)
        gram, product = rest[:-1, :-1], rest[:-1, -1]
        for place, parameters in enumerate((solve_normal(gram, product), step(links, gram, product, np.zeros(b)))):
            against = np.append(parameters, -1.0)
            error[place] += against @ block @ against
    return tuple(each.bound_to_bodies() for each in recordings) if error[1] < error[0] else tuple(recordings)


def _blocks(recording: PreparedRecording, train: Bools, weights: Floats) -> list[Floats]:
    """(k + 1, k + 1) weighted inner products of the columns and the torque in each part of the rows `train`."""
    products = []
    for part in np.array_split(np.arange(len(train)), _BLOCKS):
        rows = train[part]
        columns = np.concatenate([recording.regressor[part], recording.torque[part][:, :, None]], axis=2)[rows]
        weighted = columns * weights[part][rows][:, None]
        products.append(weighted.T @ weighted)
    return [product for product in products if product.any()]
