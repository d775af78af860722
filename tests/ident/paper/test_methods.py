import numpy as np

from ident.basics import plugins
from ident.paper import methods
from ident.paper.methods import MethodComparison


def test_all_methods_are_compared_and_the_papers_come_first(comparison: MethodComparison) -> None:
    assert list(comparison.results)[:4] == list(methods.PAPER) == ["pso", "rls", "dls", "svd"]
    assert set(comparison.results) == set(plugins.names("ident.estimation.estimators")) - {"pso_nonlinear"}


def test_the_papers_order_holds_where_there_is_friction(comparison: MethodComparison) -> None:
    assert comparison.baselines_not_below(0) == comparison.baselines_not_below(1) == []


def test_methods_with_the_true_model_find_its_parameters(comparison: MethodComparison, truth: np.ndarray) -> None:
    for name in ("pso", "lad", "ls", "wls", "pso_classic"):
        np.testing.assert_allclose(list(comparison.results[name].parameters.values()), truth, rtol=0.1)
    assert [len(comparison.results[name].parameters) for name in methods.BASELINES] == [14, 14, 14]
