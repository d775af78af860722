"""Add the ripple above the low-pass to a model that was fitted below it."""

from ident.diagnosis.ripple import Ripple
from ident.dynamics.structure import ParameterEntry
from ident.estimation.linear_fit import SEARCH_FACTOR
from ident.identification.model_file import FittedParameter, ModelFile
from ident.identification.prediction import effect_terms


def with_ripple_terms(model: ModelFile, ripple: Ripple) -> ModelFile:
    """The `model`, fitted below the low-pass, with the lines above it."""
    structure, x = ripple.structure, ripple.x
    first, before = len(ripple.model.solution.x), len(model.terms)
    added = [
        (entry, value, width)
        for entry, value, width in zip(structure.parameters[first:], x[first:], ripple.half_widths, strict=True)
        if entry.linear
    ]
    terms = effect_terms(structure, x)[before:]
    return model.model_copy(
        update={
            "effects": (*model.effects, *(term.name for term in terms)),
            "terms": (*model.terms, *terms),
            "parameters": (*model.parameters, *(_fitted(entry, value, width) for entry, value, width in added)),
        }
    )


def _fitted(entry: ParameterEntry, value: float, width: float) -> FittedParameter:
    return FittedParameter(
        name=entry.name,
        value=value,
        unit=entry.unit,
        lower=-SEARCH_FACTOR * abs(value),
        upper=SEARCH_FACTOR * abs(value),
        at_bound=False,
        paper_value=value,
        ci95=(value - width, value + width),
    )
