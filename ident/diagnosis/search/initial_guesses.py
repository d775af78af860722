"""Where the columns of an effect are tried: initial guesses of its local parameters and shapes."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from ident.dynamics.effects.base import Quantity, Suggestion
from ident.dynamics.structure import Term
from recordings.recording import Floats


def initial_guesses(term: Term, suggestions: Sequence[Suggestion]) -> list[tuple[Floats, Floats]]:
    """Local parameters (instances, c) and shapes (s,) at which columns of the `term` are made.

    They are those that its effect declares, and its `suggestions` from the residuals.
    """
    effect = term.effect
    first_parameter = effect.parameters[0].name
    complete = [suggestion for suggestion in suggestions if first_parameter in suggestion]
    shapes = term.shape_guesses([suggestion for suggestion in suggestions if first_parameter not in suggestion])
    guesses = _padded([quantity.initial_guesses or (1.0,) for quantity in term.local_parameters])
    starts = [np.array(start) for start in zip(*guesses, strict=True)]
    pairs = [
        *((np.tile(start, (term.instances, 1)), values) for start, values in product(starts, shapes)),
        *(
            (_by_instance(suggestion, term.local_parameters, term.instances), _vector(suggestion, effect.shapes))
            for suggestion in complete
        ),
    ]
    # Several recordings may suggest the same.
    return list({(start.tobytes(), values.tobytes()): (start, values) for start, values in pairs}.values())


def _vector(values: Suggestion, quantities: Sequence[Quantity]) -> Floats:
    """The `values` of the `quantities`, in their order."""
    return np.array([values[quantity.name] for quantity in quantities], float)


def _by_instance(values: Suggestion, quantities: Sequence[Quantity], instances: int) -> Floats:
    """(instances, c) `values` of the `quantities`, in their order."""
    return np.stack(
        [np.broadcast_to(np.asarray(values[quantity.name], float), instances) for quantity in quantities], axis=1
    )


def _padded(sequences: Sequence[Sequence[float]]) -> list[tuple[float, ...]]:
    """Sequences padded to the length of the longest by repeating the last value."""
    longest = max(len(sequence) for sequence in sequences)
    return [(*sequence, *[sequence[-1]] * (longest - len(sequence))) for sequence in sequences]
