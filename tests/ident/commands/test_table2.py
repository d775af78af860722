import json
from functools import partial
from pathlib import Path

import pytest

from ident.paper.methods import PAPER
from ident.program import program
from tests.running import ran

table2 = partial(ran, program, "table2")


def test_the_samples_show_the_papers_order_beside_its_values(tmp_path: Path) -> None:
    result = table2("--plots", tmp_path / "plots")
    printed = " ".join(result.stdout.split())
    for values in PAPER.values():
        for value in values:
            assert f"{value:.4f}" in printed
    assert "The paper's order holds on identification data: pso, rls, dls, svd." in printed
    assert "PSO is first on validation data on every joint, as in the paper." in printed
    assert "above RLS, DLS and SVD in 9 of 9 places on validation data: it has" in printed
    assert "Not comparable: the values" in printed
    assert "SIMULATED" in printed
    figures = sorted(path.name for path in (tmp_path / "plots").iterdir())
    assert figures == sorted(f"figure_{number}.{kind}" for number in (3, 6, 7, 8, 9, 10) for kind in ("csv", "png"))


@pytest.mark.slow
def test_a_study_compares_swarms_of_several_sizes_and_seeds(tmp_path: Path) -> None:
    brief = ["--set", "pso.iterations=40", "--set", "pso_classic.iterations=40", "--plots", tmp_path / "plots"]
    document = json.loads(table2("--json", "--seed", 3, "--seeds", 2, "--sizes", "12,30", *brief).stdout)
    groups = {(group["method"], group["particles"]): group for group in document["study"]}
    assert set(groups) == {(method, size) for method in ("pso", "pso_classic") for size in (12, 30)}
    assert [groups["pso", size]["neighbours"] for size in (12, 30)] == [2, 6]
    assert all(group["seeds"] == [3, 4] for group in groups.values())
    assert groups["pso", 30]["excess"]["median"] < groups["pso", 12]["excess"]["median"]
    names = {path.name for path in (tmp_path / "plots").iterdir()}
    assert {"study.png", "study.csv", "convergence.csv"} < names
