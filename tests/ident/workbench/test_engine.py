"""Manual stepwise selection without a page: the same models and numbers as `ident diagnose`."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.search.screening import Screener
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.estimation.estimators import settings
from ident.identification import model_file
from ident.identification.identify import FitOptions, identify
from ident.residuals.time_span import TorqueSeries
from ident.workbench.state.cli_equivalent import shell_script, swarm_command
from ident.workbench.worker import views
from ident.workbench.worker.engine import SelectionEngine
from ident.workbench.worker.model_views import removed_torques
from recordings.errors import BadInput
from recordings.recording import Floats
from tests.ident import building
from tests.ident.commands.test_axes import write

SAMPLES = Path("recordings/samples")
TRAIN, VALIDATE = SAMPLES / "fig5a.mcap", SAMPLES / "fig5b.mcap"


@pytest.fixture
def engine() -> Any:
    """Return an engine, whose tasks yield views of known types."""
    return SelectionEngine(lambda text: None)


def test_view_of_a_recording_and_of_one_that_cannot_validate_it(engine: Any, tmp_path: Path) -> None:
    (view,) = engine.view_recording(TRAIN, VALIDATE)
    assert view.quality["Drives"].startswith("simulated")
    assert view.signals["position"][1].shape == (len(view.time), 3)
    assert not view.warnings
    mismatch, view = engine.view_recording(TRAIN, write(tmp_path / "slide.mcap", 0))
    assert "slide.mcap cannot validate a model of fig5a.mcap: " in mismatch.reason
    assert view.name == "fig5a.mcap"


def test_a_huge_file_is_refused_before_it_fills_the_memory(engine: Any, tmp_path: Path) -> None:
    with (tmp_path / "huge.mcap").open("wb") as file:
        file.truncate(2**30)
    with pytest.raises(BadInput, match="is not an MCAP file"):
        next(engine.view_recording(tmp_path / "huge.mcap"))


def spec_of(made: views.StepsView, validate: Path | None = VALIDATE) -> views.StepsSpec:
    return views.StepsSpec(TRAIN, validate, made.steps)


@pytest.mark.slow
def test_fit_add_remove_and_return(engine: Any) -> None:
    made, series, candidates, _, residuals, advice = engine.fit(TRAIN, VALIDATE)
    assert advice == views.Advice(None), "within the noise"
    assert [step.label for step in made.steps] == ["base model", "+ rod_inertia"]
    assert [item.held_out for item in series] == [False, True]
    base, last = (step.entry for step in made.steps)
    for item, before, after in zip(
        series, (base.train_rms, base.held_out_rms), (last.train_rms, last.held_out_rms), strict=True
    ):
        assert item.previous is not None
        previous = np.where(item.scored, item.measured - item.previous, np.nan)
        np.testing.assert_allclose(np.sqrt(np.nanmean(previous**2, axis=0)), before)
        np.testing.assert_allclose(np.sqrt(np.nanmean(item.residual**2, axis=0)), after)
    assert residuals.recordings == ("fig5b.mcap",)
    improvements = [card.improvement for card in candidates.cards]
    assert improvements == sorted(improvements, reverse=True)

    best = candidates.cards[0].name
    added = next(engine.add(spec_of(made), best))
    before, after = (np.sum(np.square(step.entry.train_rms)) for step in added.steps[1:])
    assert after <= before * (1 + 1e-6), "at worst, the effect is not there"
    assert [bool(step.refusal) for step in added.steps] == [False, False, True], "nothing is hidden in the samples"
    bare, *_, advice = engine.remove(spec_of(added), 0)
    assert (advice.effect, advice.refusal) == ("rod_inertia", "")
    assert bare.steps[-1].label == "− rod_inertia"
    assert f"--only {best}" in shell_script(added, "m.json")
    assert "rod_inertia" not in shell_script(made, "m.json"), "ident fit includes it"
    assert "--without rod_inertia" in shell_script(bare, "m.json")
    shown = next(engine.show(spec_of(added)))
    assert residual_rms(shown) == pytest.approx(added.steps[-1].entry.train_rms)
    with pytest.raises(BadInput, match="another card"):
        next(engine.add(spec_of(made), "__import__('os')"))
    with pytest.raises(BadInput, match="number 8"):
        next(engine.remove(spec_of(made), 7))


@pytest.mark.slow
def test_all_errors_are_those_of_the_rows_that_the_last_model_can_be_judged_by(engine: Any) -> None:
    """A curve over the position says nothing beyond the travel of training: thousands of N m where it continues."""
    made = next(engine.fit(TRAIN, VALIDATE))
    curve, *_, residuals, _ = engine.add(spec_of(made), "position_torque")
    *_, before, last = (step.entry.held_out_rms for step in curve.steps)
    assert before != made.steps[-1].entry.held_out_rms
    np.testing.assert_allclose(last, before, rtol=0.1)
    said = [each.name for each in residuals.model.assessment.warnings]
    assert any(name.startswith("T_g and position_torque.g") for name in said), "gravity is a curve over the position"
    assert "5.7% (joint 2) are not scored" in curve.warnings[0]
    without = next(engine.remove(spec_of(curve), 1))
    assert without.steps[1].entry == made.steps[1].entry
    assert not without.warnings


@pytest.mark.slow
def test_advice_says_what_the_judge_refuses(engine: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    made = next(engine.fit(TRAIN, VALIDATE))
    monkeypatch.setattr("ident.workbench.worker.engine.refusal", lambda before, after: "chance does as much")
    *_, advice = engine.remove(spec_of(made), 0)
    assert (advice.effect, advice.refusal) == ("rod_inertia", "chance does as much")


def residual_rms(series: tuple[TorqueSeries, ...]) -> Floats:
    """Error of each joint in the training recording."""
    return np.sqrt(np.nanmean(series[0].residual ** 2, axis=0))


def test_new_process_goes_on_from_the_same_models(engine: Any) -> None:
    made, series, *_ = engine.fit(TRAIN, None)
    new_process: Any = SelectionEngine(lambda text: None)
    shown, *_, residuals, _ = new_process.show(replace(spec_of(made, None), diagnosed=True))
    assert residuals.model.residual_test.diagnosed, "as it was said before"
    for before, after in zip(series, shown, strict=True):
        np.testing.assert_allclose(after.computed, before.computed, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(after.previous, before.previous, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
def test_model_of_a_file_is_opened(engine: Any, tmp_path: Path) -> None:
    options = FitOptions("wls", settings("wls", {}), 0, "parallel", None, ("stribeck:2",), base_effects=True)
    fit = identify([TRAIN], (), options, lambda *_: None)
    model_file.save(fit.model, tmp_path / "a.model.json")
    made = next(engine.fit(TRAIN, VALIDATE, tmp_path / "a.model.json"))
    assert dict(made.steps[-1].terms)["stribeck"] == (2,)


def test_swarm_is_the_command_that_fits_the_same_model(engine: Any) -> None:
    made = next(engine.fit(TRAIN, None))
    command = swarm_command(made, "a.mcap", "b.mcap", "3", "a.pso")
    cutoff = f"{made.bandwidth:g}"
    assert " ".join(command) == (
        f"ident fit a.mcap --validate b.mcap --seed 3 --cutoff {cutoff} -o a.pso.model.json --pictures a.pso.pictures"
    )
    assert " ".join(swarm_command(None, "a.mcap", None, "0", "a")) == (
        "ident fit a.mcap --seed 0 -o a.model.json --pictures a.pictures"
    )


@pytest.mark.slow
def test_long_recording_is_analysed_in_excerpts(engine: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ident.data.excerpts.MAX_DURATION", 8.0)
    monkeypatch.setattr("ident.data.excerpts.COUNT", 2)
    made, series, *_, residuals, _ = engine.fit(TRAIN, VALIDATE)
    assert made.excerpt
    assert [item.held_out for item in series] == [False, False, True, True]
    assert residuals.model.effects == ("rod_inertia",)
    assert residuals.model.train.fitted.rms == pytest.approx(made.steps[-1].entry.train_rms)
    assert residuals.recordings == ("fig5b.mcap",)
    assert residuals.windows
    for window in residuals.windows:
        assert any(item.held_out and item.time[0] <= window.start < window.end <= item.time[-1] for item in series)


def drag(motion: Motion) -> Floats:
    return 0.5 * motion.velocity * np.abs(motion.velocity)


def test_linear_effect_removes_what_the_refit_removes() -> None:
    """Also on the recording that the fit did not see."""
    train, other = building.record(2, noise=0.05, extra=drag), building.record(2, 3, shape=1, extra=drag, name="b")
    train.position[600:610] = np.nan
    data = building.split([train], [other])
    model, refitted = building.fitted(data), building.fitted(data, "quadratic_friction")
    effects = {"quadratic_friction": library()["quadratic_friction"]}
    (candidate,) = Screener(data, model.solution).screen(effects).candidates
    (removed,) = removed_torques(data, model.solution, [candidate])
    for torque, before, after in zip(removed, model.residuals, refitted.residuals, strict=True):
        np.testing.assert_allclose(torque, before - after, atol=1e-6)
    assert np.isnan(removed[0][300:305]).all(), "unknown rows stay unknown"
