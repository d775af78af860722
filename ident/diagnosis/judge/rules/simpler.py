"""An effect that does not differ from a simpler one is that simpler one, which stands for itself in the search."""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_T
from ident.diagnosis.judge.rules.strength import local_entries


def reason(before: FittedModel, after: FittedModel, index: int) -> str | None:
    """Say which simpler effect the effect does not differ from."""
    name = simpler_effect(after, index)
    return f"it does not differ from {name}" if name else None


def simpler_effect(model: FittedModel, index: int) -> str | None:
    """The effect that the term `index` of `model` reduces to, because its distinguishing parameter may be zero.

    None where there is none. The parameter must not differ from zero on any joint, by the t of an improvement.
    """
    term = model.terms[index]
    columns = [i for i, quantity in enumerate(term.local_parameters) if quantity.reduces_to]
    if not columns:
        return None
    local = np.abs(model.solution.structure.local_values(index, model.solution.x))
    zero = np.all(~(local > MIN_T * model.standard_errors[local_entries(model, index)]), axis=0)
    return next((term.local_parameters[column].reduces_to for column in columns if zero[column]), None)
