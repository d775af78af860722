from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.basics import plugins
from ident.identification.goodness_of_fit import GoodnessOfFit
from ident.paper import methods
from ident.paper.methods import MethodComparison
from recordings.errors import BadInput
from recordings.recording import Recording
from recordings.rig import Axis, Rig


def test_all_methods_are_compared_and_the_papers_come_first(comparison: MethodComparison) -> None:
    assert list(comparison.results)[:4] == list(methods.PAPER) == ["pso", "rls", "dls", "svd"]
    assert set(comparison.results) == set(plugins.names("ident.estimation.estimators")) - {"pso_nonlinear"}


def test_the_papers_order_holds_where_there_is_friction(comparison: MethodComparison) -> None:
    assert comparison.baselines_not_below(0) == comparison.baselines_not_below(1) == []


def test_methods_with_the_true_model_find_its_parameters(comparison: MethodComparison, truth: np.ndarray) -> None:
    for name in ("pso", "lad", "ls", "wls", "pso_classic"):
        np.testing.assert_allclose(list(comparison.results[name].parameters.values()), truth, rtol=0.1)
    assert [len(comparison.results[name].parameters) for name in methods.BASELINES] == [14, 14, 14]


def test_baselines_not_below_pso_are_named_with_their_joint(comparison: MethodComparison) -> None:
    poor = GoodnessOfFit(nrmse=(0.99, 0.0, 0.99), rms=(1.0,) * 3, r2=(0.0,) * 3)
    pso = replace(comparison.results["pso"], goodness_of_fit=(poor, comparison.results["pso"].goodness_of_fit[1]))
    changed = replace(comparison, results={**comparison.results, "pso": pso})
    assert changed.baselines_not_below(0) == [("rls", 2), ("dls", 2), ("svd", 2)]
    assert changed.baselines_not_below(1) == []


def test_another_mechanism_is_refused(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    bench = Rig(name="bench", mechanism="axes", axes=(Axis(), Axis(), Axis()))
    path = write(replace(make(cycles=1, rate=250.0, path=tmp_path / "bench.mcap"), rig=bench))
    with pytest.raises(BadInput, match="a delta robot expected, axes found"):
        methods.compare_methods([path, path], "central", 0, lambda *_: None)
