"""The whole chain: recordings of the simulated rig, fitted and judged on a motion that the fit has not seen."""

import json
from pathlib import Path

import pytest

from tests.conftest import Runner
from tests.documents import ROOT

SAMPLES = ROOT / "recordings" / "samples"


@pytest.mark.slow
def test_fit_of_fig5a_explains_fig5b_and_repeats(ident: Runner, tmp_path: Path) -> None:
    for name in ("one", "two"):
        files = (SAMPLES / "fig5a.mcap", "--validate", SAMPLES / "fig5b.mcap")
        done = ident("fit", *files, "-o", f"{name}.json")
        assert done.code == 0, done.err
    assert (tmp_path / "one.json").read_bytes() == (tmp_path / "two.json").read_bytes()
    validation = json.loads((tmp_path / "one.json").read_text())["validate"]
    assert min(validation["fitted"]["nrmse"]) >= 0.95
    # The model to beat: Table 1 in Eq. (1).
    assert max(validation["nominal"]["nrmse"]) < min(validation["fitted"]["nrmse"])
