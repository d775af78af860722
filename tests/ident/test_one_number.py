"""Fit, compare, diagnosis, report and page state one number for one model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.output.report.contents import ReportRequest, gather
from ident.workbench.worker.engine import SelectionEngine
from ident.workbench.worker.views import StepsView
from tests.ident.conftest import write_recording
from tests.ident.data_problems.test_mistakes import robot


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 5))])
def test_held_out_error_is_the_same_everywhere(seed: int, tmp_path: Path) -> None:
    train, held_out = (
        write_recording(replace(robot(seed, motion), path=tmp_path / f"{motion}.mcap"))
        for motion in ("fig5a", "fig5b")
    )
    model = ident.fit([train], validate=held_out, method="wls")
    model.save(tmp_path / "m.json")
    compared = ident.compare(model, [held_out])
    request = ReportRequest((tmp_path / "m.json",), (train,), (held_out,), (), diagnose=True)
    report = gather(request, lambda text: None)
    document = report.diagnosis.document
    (step,) = (step for step in document.steps if step.effects == model.file.effects)
    stated = np.array([joint.summary.rms for joint in compared.joints])
    np.testing.assert_allclose(step.held_out_rms, stated, rtol=1e-6)
    in_report = report.held_out_analyses["m.json"]
    np.testing.assert_allclose([joint.summary.rms for joint in in_report.joints], stated, rtol=1e-12)
    np.testing.assert_allclose(model.file.validate_.fitted.rms, stated, rtol=1e-12)
    assert f"RMS {', '.join(f'{error:.3g}' for error in stated)} N m held out" in repr(model)
    page = next(SelectionEngine(lambda text: None).fit(train, held_out))
    assert isinstance(page, StepsView)
    np.testing.assert_allclose(page.steps[-1].entry.held_out_rms, stated, rtol=1e-6)
