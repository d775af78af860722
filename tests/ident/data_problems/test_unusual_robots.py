"""Robots without weight, or with an unusual one, have no data problem."""

import numpy as np
import pytest

from ident.data_problems import check_data

pytest.importorskip("pinocchio")

from tests.ident import arms

KINDS = {
    "balanced": (arms.SHOULDER, "0 0 0.02"),
    "vertical": (("0 0 1", "0 0 1", "0 0 1"), "0.2 0.01 0.05"),
    "horizontal": (("0 1 0", "0 1 0", "0 1 0"), "0.2 0.01 0.05"),
    "one of each": (("0 0 1", "1 0 0", "0 1 0"), "0.1 0.02 -0.03"),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("known", [True, False], ids=["masses", "lengths alone"])
def test_nothing_is_said_of_right_data(kind: str, seed: int, known: bool) -> None:
    axes, centre = KINDS[kind]
    random = np.random.default_rng(seed)
    mass = random.uniform(0.7, 1.4)
    true = arms.urdf(axes, centre=centre, length=round(random.uniform(0.2, 0.6), 2))
    told = true.replace('<mass value="2"/>', f'<mass value="{2 * mass:.2f}"/>')  # catalogues are never quite right
    recording = arms.record(true, told if known else arms.without_masses(true), seed=seed)
    assert check_data([recording]).data_problems == ()
