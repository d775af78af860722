"""Data of a stepwise selection."""

from ident.diagnosis.steps import FittedModel
from tests.ident import building


def test_effects_of_a_fitted_model_are_those_of_its_structure() -> None:
    data = building.split([building.record(2)])
    model = building.fitted(data, "torque_offset", joints=(1,))
    assert isinstance(model, FittedModel)
    assert [(term.name, term.joints) for term in model.terms] == [("torque_offset", (1,))]
    assert building.fitted(data).terms == ()
