"""Manual stepwise selection without a page: the same models and numbers as `ident diagnose`."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.estimation.estimators import settings
from ident.identification.identify import FitOptions, identify
from ident.workbench import views
from ident.workbench.cli_equivalent import shell_script
from ident.workbench.engine import Engine
from ident.workbench.time_span import describe_span, explain_gaps, rank_effects, summary
from recordings.errors import BadInput
from tests.ident.commands.test_axes import write

SAMPLES = Path("recordings/samples")
TRAIN, VALIDATE = SAMPLES / "fig5a.mcap", SAMPLES / "fig5b.mcap"


@pytest.fixture
def engine() -> Engine:
    return Engine(lambda text: None)


def steps_of(task: object) -> views.StepsView:
    view = next(iter(task))  # type: ignore[call-overload]
    assert isinstance(view, views.StepsView)
    return view


def test_view_of_a_recording(engine: Engine) -> None:
    (view,) = engine.view_recording(TRAIN)
    assert isinstance(view, views.RecordingView)
    assert view.quality["Drives"].startswith("simulated")
    assert view.signals["position"][1].shape == (len(view.time), 3)
    assert not view.warnings


def test_recording_of_another_machine_cannot_validate(engine: Engine, tmp_path: Path) -> None:
    slide = write(tmp_path / "slide.mcap", 0)
    mismatch, view = engine.view_recording(TRAIN, slide)
    assert isinstance(mismatch, views.Mismatch)
    assert "slide.mcap cannot validate a model of fig5a.mcap" in mismatch.reason
    assert "mechanism is delta in fig5a.mcap, axes in slide.mcap" in mismatch.reason
    assert isinstance(view, views.RecordingView)
    assert len([*engine.view_recording(TRAIN, VALIDATE)]) == 1


def spec_of(step_list: views.StepsView, validate: Path | None = VALIDATE) -> views.StepsSpec:
    return views.StepsSpec(TRAIN, validate, tuple(step.spec for step in step_list.steps))


def test_fit_add_remove_and_return(engine: Engine) -> None:
    step_list, series, candidates, _, residuals = engine.fit(TRAIN, VALIDATE)
    assert isinstance(step_list, views.StepsView)
    assert [step.label for step in step_list.steps] == ["base model", "+ rod_inertia"]
    assert isinstance(series, tuple)
    assert [item.held_out for item in series] == [False, True]
    for item, before in zip(
        series, step_list.steps[0].entry.train_rms[:1] + step_list.steps[0].entry.held_out_rms[:1], strict=True
    ):
        assert item.previous is not None
        rms = np.sqrt(np.mean((item.measured - item.previous)[item.scored[:, 0], 0] ** 2))
        np.testing.assert_allclose(rms, before)
    for number, item in enumerate(series):
        rms = np.sqrt(np.nanmean(item.residual**2, axis=0))
        entry = step_list.steps[-1].entry
        np.testing.assert_allclose(rms, (entry.train_rms, entry.held_out_rms)[number])
    assert isinstance(residuals, views.ResidualView)
    assert residuals.recordings == ("fig5b.mcap",)
    assert residuals.model
    assert isinstance(candidates, views.CandidateList)
    improvements = [card.improvement for card in candidates.cards]
    assert improvements == sorted(improvements, reverse=True)

    added = steps_of(engine.add(spec_of(step_list), candidates.cards[0].name))
    assert len(added.steps) == 3
    before, after = (np.sum(np.square(step.entry.train_rms)) for step in added.steps[1:])
    assert after <= before * (1 + 1e-6), "at worst, the effect is not there"
    assert [step.refusal for step in added.steps[:2]] == ["", ""]
    assert added.steps[2].refusal, "nothing is hidden in the samples: the judge does not accept what is added by hand"
    assert f"--only {candidates.cards[0].name}" in shell_script(added, "m.json")
    assert "ident fit" in shell_script(step_list, "m.json")
    assert "rod_inertia" not in shell_script(step_list, "m.json"), "ident fit includes it"
    bare = steps_of(engine.remove(spec_of(added), 0))
    assert bare.steps[-1].label == "− rod_inertia"
    assert "--without rod_inertia" in shell_script(bare, "m.json")
    assert steps_of(engine.show(spec_of(added))).steps == added.steps, "known steps are not fitted again"
    assert steps_of(engine.show(spec_of(step_list))).steps == step_list.steps


@pytest.mark.slow
def test_contribution_of_a_candidate_agrees_with_its_improvement(engine: Engine) -> None:
    """Checked on the training rows; on the other rows the effect has the same coefficient."""
    step_list, series, candidates, previews, _ = engine.fit(TRAIN, VALIDATE)
    assert isinstance(step_list, views.StepsView)
    assert isinstance(series, tuple)
    assert isinstance(candidates, views.CandidateList)
    assert isinstance(previews, views.CandidatePreviews)
    assert set(previews.contributions) == set(previews.figures) == {card.name for card in candidates.cards}
    residual = series[0].residual
    for card in candidates.cards[:4]:
        contributions = previews.contributions[card.name]
        assert [contribution.shape for contribution in contributions] == [item.residual.shape for item in series]
        improvement = 1 - np.nansum((residual - contributions[0]) ** 2) / np.nansum(residual**2)
        assert improvement == pytest.approx(card.improvement, abs=0.03), (
            "rows are weighted by their noise, equal here"
        )


def test_new_process_rebuilds_the_same_steps(engine: Engine) -> None:
    step_list = steps_of(engine.fit(TRAIN, None))
    rebuilt = steps_of(Engine(lambda text: None).show(spec_of(step_list, None)))
    for before, after in zip(step_list.steps, rebuilt.steps, strict=True):
        assert after.label == before.label
        np.testing.assert_allclose(after.entry.train_rms, before.entry.train_rms, rtol=1e-6)
        np.testing.assert_allclose(after.entry.held_out_rms, before.entry.held_out_rms, rtol=1e-6)


def test_impossible_tasks_are_refused(engine: Engine) -> None:
    base = spec_of(steps_of(engine.fit(TRAIN, None)), None)
    with pytest.raises(BadInput, match="another card"):
        next(engine.add(base, "__import__('os')"))
    with pytest.raises(BadInput, match="number 8"):
        next(engine.remove(base, 7))


@pytest.mark.slow
def test_swarm_reports_progress_and_agrees_with_ident_fit() -> None:
    reports: list[views.SwarmProgress] = []
    engine = Engine(lambda text: None, (), reports.append)
    (result,) = engine.swarm(TRAIN, VALIDATE, views.SwarmRequest(("stribeck:2",), 30.0, 3))
    assert isinstance(result, views.SwarmResult)
    assert result.command == "ident fit fig5a.mcap --validate fig5b.mcap --cutoff 30 --with stribeck:2 --seed 3"
    choices = FitOptions("pso", settings("pso", {}), 3, "parallel", 30.0, ("stribeck:2",), base_effects=True)
    model = identify([TRAIN], VALIDATE, choices, lambda *_: None).model
    assert result.model.parameters == model.parameters
    assert model.method.certified
    assert result.progress.excess[-1] == pytest.approx(model.method.certified.excess)
    assert reports
    assert result.progress.excess[: len(reports[-1].excess)] == reports[-1].excess


@pytest.fixture
def slow_then_fast() -> views.TorqueSeries:
    """One joint that is slow and badly explained for a second, then fast."""
    time = np.arange(400) / 100
    return views.TorqueSeries(
        name="made",
        held_out=False,
        time=time,
        measured=np.where(time < 1, 0.5, 0.1)[:, None] * np.cos(40 * time)[:, None],
        computed=np.zeros((400, 1)),
        velocity=np.where(time < 1, 0.1, 1.0)[:, None],
        position=time[:, None],
        phase=np.where(time < 1, "reversal", "cruise")[:, None],
        cycle=np.where(time < 2, 1, 2),
        scored=np.ones((400, 1), bool),
    )


def test_description_of_a_span(slow_then_fast: views.TorqueSeries) -> None:
    text = " ".join(describe_span(slow_then_fast, 0, 0.0, 0.99))
    assert "5.0 times the residual elsewhere" in text
    assert "Speed 0.1 rad/s median, slower than usual" in text
    assert "reversal 100 % (usually 25 %)" in text
    assert "Cycle 1." in text
    assert "too short" in describe_span(slow_then_fast, 0, 0.0, 0.01)[0]
    assert "covers everything" in describe_span(slow_then_fast, 0, 0.0, 9.0)[0]


def test_ranking_of_the_effects_that_explain_a_span(slow_then_fast: views.TorqueSeries) -> None:
    residual = slow_then_fast.residual.astype(np.float32)
    contributions = {
        "nothing": 0 * residual,
        "half": residual / 2,
        "all": residual,
        "worse": -residual,
        "all, but late": np.roll(residual, 200),
    }
    shares = rank_effects(slow_then_fast, contributions, 0, 0.0, 0.99)
    assert [*shares][:2] == ["all", "half"]
    assert [*shares][-1] == "worse"
    assert shares["all"] == pytest.approx(1.0)
    assert shares["half"] == pytest.approx(0.75)
    assert shares["worse"] == pytest.approx(-3.0)
    assert "would explain" in summary(shares)
    none = rank_effects(slow_then_fast, {"nothing": 0 * residual, "worse": -residual}, 0, 0.0, 0.99)
    assert (
        summary(none)
        == "No effect of the library explains this selection: nothing explains most, 0 % of its mean square."
    )
    assert "too short" in summary(rank_effects(slow_then_fast, contributions, 0, 0.0, 0.01))


@pytest.mark.slow
def test_long_recording_is_analysed_in_excerpts(engine: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ident.data.excerpts.MAX_DURATION", 8.0)
    monkeypatch.setattr("ident.data.excerpts.COUNT", 2)
    step_list, series, *_, residuals = engine.fit(TRAIN, VALIDATE)
    assert isinstance(step_list, views.StepsView)
    assert step_list.excerpt
    assert isinstance(series, tuple)
    assert [item.held_out for item in series] == [False, False, True, True]
    assert isinstance(residuals, views.ResidualView)
    assert residuals.model.effects == ("rod_inertia",)
    assert residuals.model.train.fitted.rms == pytest.approx(step_list.steps[-1].entry.train_rms)
    assert residuals.recordings == ("fig5b.mcap",)
    assert residuals.windows
    for window in residuals.windows:
        assert any(item.held_out and item.time[0] <= window.start < window.end <= item.time[-1] for item in series)


def test_gaps_of_the_residual_are_explained(slow_then_fast: views.TorqueSeries) -> None:
    assert explain_gaps(slow_then_fast, 0) == ""
    scored, measured, cycle = (
        slow_then_fast.scored.copy(),
        slow_then_fast.measured.copy(),
        slow_then_fast.cycle.copy(),
    )
    scored[:40], cycle[:40] = False, 0
    measured[100:120] = np.nan
    scored[200:220] = False
    text = explain_gaps(replace(slow_then_fast, scored=scored, measured=measured, cycle=cycle), 0)
    assert "10% outside of the repeated motion; 5% lost" in text
    assert "5% at standstill" in text
