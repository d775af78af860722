"""Add the ripple above the low-pass to a model that was fitted below it."""

from ident.diagnosis.ripple.ripple import Ripple
from ident.dynamics.structure import ParameterEntry
from ident.estimation.linear_fit import SEARCH_FACTOR
from ident.identification.model_file import FittedParameter, ModelFile
from ident.identification.prediction import effect_terms


def with_ripple_terms(model: ModelFile, ripple: Ripple) -> ModelFile:
    """The `model`, fitted below the low-pass, with the lines above it."""
    structure, x = ripple.structure, ripple.x
    first, before = len(ripple.model.solution.x), len(model.terms)
    lines = list(zip(structure.parameters[first:], x[first:].tolist(), ripple.half_widths.tolist(), strict=True))
    terms = effect_terms(structure, x)[before:]
    return model.model_copy(
        update={
            "effects": (*model.effects, *(term.name for term in terms)),
            "terms": (*model.terms, *terms),
            "parameters": (*model.parameters, *(_fitted(*line) for line in lines if line[0].linear)),
            "searched": (*model.searched, *(_fitted(*line) for line in lines if not line[0].linear)),
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
        shape_ci95=(value - width, value + width),
    )
