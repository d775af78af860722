"""The climb by hand, without a page: the same models and numbers as `ident diagnose`."""

from pathlib import Path

import numpy as np
import pytest

from ident.estimation.estimators import settings
from ident.identification.identify import Choices, identify
from ident.workbench import views
from ident.workbench.cli_equivalent import shell_script
from ident.workbench.engine import Engine
from ident.workbench.selection import rank_effects, describe_span, summary
from recordings.errors import BadInput
from tests.ident.commands.test_axes import write

SAMPLES = Path("recordings/samples")
TRAIN, VALIDATE = SAMPLES / "fig5a.mcap", SAMPLES / "fig5b.mcap"


@pytest.fixture
def engine() -> Engine:
    return Engine(lambda text: None)


def ladder_of(task: object) -> views.LadderView:
    shown = next(iter(task))  # type: ignore[call-overload]
    assert isinstance(shown, views.LadderView)
    return shown


def test_a_recording_as_it_is(engine: Engine) -> None:
    (view,) = engine.view_recording(TRAIN)
    assert isinstance(view, views.RecordingView)
    assert dict(view.quality)["Drives"].startswith("simulated")
    assert view.signals["position"][1].shape == (len(view.time), 3)
    assert not view.warnings


def test_a_recording_of_another_machine_cannot_be_checked_on(engine: Engine, tmp_path: Path) -> None:
    slide = write(tmp_path / "slide.mcap", 0)
    found, view = engine.view_recording(TRAIN, slide)
    assert isinstance(found, views.Mismatch)
    assert "slide.mcap cannot check a model of fig5a.mcap" in found.reason
    assert "mechanism is delta in fig5a.mcap, axes in slide.mcap" in found.reason
    assert isinstance(view, views.RecordingView)
    assert len([*engine.view_recording(TRAIN, VALIDATE)]) == 1


def place_of(ladder: views.LadderView, validate: Path | None = VALIDATE) -> views.LadderSpec:
    return views.LadderSpec(TRAIN, validate, tuple(rung.spec for rung in ladder.steps))


def test_fit_add_remove_and_back(engine: Engine) -> None:
    ladder, series, choice, _, failing = engine.fit(TRAIN, VALIDATE)
    assert isinstance(ladder, views.LadderView)
    assert [rung.label for rung in ladder.steps] == ["base model", "+ rod_inertia"]
    assert isinstance(series, tuple)
    assert [one.held_out for one in series] == [False, True]
    for number, one in enumerate(series):
        rms = np.sqrt(np.nanmean(one.residual**2, axis=0))
        entry = ladder.steps[-1].entry
        np.testing.assert_allclose(rms, (entry.train_rms, entry.validate_rms)[number])
    assert isinstance(failing, views.ResidualView)
    assert failing.recordings == ("fig5b.mcap",)
    assert failing.model
    assert isinstance(choice, views.CandidateList)
    gains = [one.improvement for one in choice.cards]
    assert gains == sorted(gains, reverse=True)

    added = ladder_of(engine.add(place_of(ladder), choice.cards[0].name))
    assert len(added.steps) == 3
    before, after = (np.sum(np.square(rung.entry.train_rms)) for rung in added.steps[1:])
    assert after <= before * (1 + 1e-6), "at worst, the effect is not there"
    assert f"--only {choice.cards[0].name}" in shell_script(added, "m.json")
    assert "ident fit" in shell_script(ladder, "m.json")
    assert "--with rod_inertia" in shell_script(ladder, "m.json")
    bare = ladder_of(engine.remove(place_of(added), 0))
    assert bare.steps[-1].label == "− rod_inertia"
    assert "--with rod_inertia" not in shell_script(bare, "m.json")
    assert ladder_of(engine.show(place_of(added))).steps == added.steps, "what is known is not fitted again"
    assert ladder_of(engine.show(place_of(ladder))).steps == ladder.steps


@pytest.mark.slow
def test_what_a_candidate_would_take_away_is_what_its_gain_says(engine: Engine) -> None:
    """On the rows that fits see; on the others it is the same effect with the same coefficient."""
    ladder, series, choice, signatures, _ = engine.fit(TRAIN, VALIDATE)
    assert isinstance(ladder, views.LadderView)
    assert isinstance(series, tuple)
    assert isinstance(choice, views.CandidateList)
    assert isinstance(signatures, views.CandidatePreviews)
    assert set(signatures.contributions) == set(signatures.figures) == {one.name for one in choice.cards}
    seen = series[0].residual
    for one in choice.cards[:4]:
        parts = signatures.contributions[one.name]
        assert [part.shape for part in parts] == [part.residual.shape for part in series]
        gain = 1 - np.nansum((seen - parts[0]) ** 2) / np.nansum(seen**2)
        assert gain == pytest.approx(one.improvement, abs=0.03), "rows count by their noise, here all alike"


def test_another_process_goes_on_from_the_same_ladder(engine: Engine) -> None:
    ladder = ladder_of(engine.fit(TRAIN, None))
    again = ladder_of(Engine(lambda text: None).show(place_of(ladder, None)))
    for before, after in zip(ladder.steps, again.steps, strict=True):
        assert after.label == before.label
        np.testing.assert_allclose(after.entry.train_rms, before.entry.train_rms, rtol=1e-6)
        np.testing.assert_allclose(after.entry.validate_rms, before.entry.validate_rms, rtol=1e-6)


def test_what_cannot_be_done_is_said(engine: Engine) -> None:
    place = place_of(ladder_of(engine.fit(TRAIN, None)), None)
    with pytest.raises(BadInput, match="another card"):
        next(engine.add(place, "__import__('os')"))
    with pytest.raises(BadInput, match="number 8"):
        next(engine.remove(place, 7))


@pytest.mark.slow
def test_the_swarm_is_watched_and_finds_what_ident_fit_finds() -> None:
    told: list[views.SwarmProgress] = []
    engine = Engine(lambda text: None, (), told.append)
    (found,) = engine.swarm(TRAIN, VALIDATE, views.SwarmRequest(("stribeck:2",), 30.0, 3))
    assert isinstance(found, views.SwarmResult)
    assert found.command == "ident fit fig5a.mcap --validate fig5b.mcap --cutoff 30 --with stribeck:2 --seed 3"
    choices = Choices("pso", settings("pso", {}), 3, "parallel", 30.0, ("stribeck:2",))
    model = identify([TRAIN], VALIDATE, choices, lambda *_: None).model
    assert found.model.parameters == model.parameters
    assert model.method.certified
    assert found.progress.excess[-1] == pytest.approx(model.method.certified.excess)
    assert told
    assert found.progress.excess[: len(told[-1].excess)] == told[-1].excess


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


def test_what_is_special_about_a_part(slow_then_fast: views.TorqueSeries) -> None:
    told = " ".join(describe_span(slow_then_fast, 0, 0.0, 0.99))
    assert "5.0 times that of the rest" in told
    assert "Speed 0.1 rad/s in the median, slower than usual" in told
    assert "reversal 100 % (usually 25 %)" in told
    assert "Cycle 1." in told
    assert "Too little" in describe_span(slow_then_fast, 0, 0.0, 0.01)[0]
    assert "all of it" in describe_span(slow_then_fast, 0, 0.0, 9.0)[0]


def test_which_effect_explains_a_part(slow_then_fast: views.TorqueSeries) -> None:
    left = slow_then_fast.residual.astype(np.float32)
    removed = {
        "nothing": 0 * left,
        "half": left / 2,
        "all": left,
        "worse": -left,
        "all, but late": np.roll(left, 200),
    }
    found = rank_effects(slow_then_fast, removed, 0, 0.0, 0.99)
    assert [one.effect for one in found[:2]] == ["all", "half"]
    assert found[0].share == pytest.approx(1.0)
    assert found[1].share == pytest.approx(0.75)
    assert found[-1].effect == "worse"
    assert found[-1].share == pytest.approx(-3.0)
    assert "would explain" in summary(found)
    none = rank_effects(slow_then_fast, {"nothing": 0 * left, "worse": -left}, 0, 0.0, 0.99)
    assert (
        summary(none)
        == "No effect of the library explains this part: nothing takes away most, 0 % of its mean square."
    )
    assert "Too little" in summary(rank_effects(slow_then_fast, removed, 0, 0.0, 0.01))


@pytest.mark.slow
def test_a_long_recording_is_looked_at_in_parts_and_fitted_as_a_whole_when_asked(
    engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ident.data.excerpts.LONGEST", 8.0)
    monkeypatch.setattr("ident.data.excerpts.PARTS", 2)
    ladder, series, *_, failing = engine.fit(TRAIN, VALIDATE)
    assert isinstance(ladder, views.LadderView)
    assert ladder.excerpt
    assert isinstance(series, tuple)
    assert [one.held_out for one in series] == [False, False, True, True]
    assert isinstance(failing, views.ResidualView)
    assert failing.model is None
    assert failing.recordings == ("fig5b.mcap",)
    assert failing.windows
    for window in failing.windows:
        assert any(one.held_out and one.time[0] <= window.start < window.end <= one.time[-1] for one in series)
    (whole,) = engine.fit_whole_recording(place_of(ladder), ladder.bandwidth)
    assert isinstance(whole, views.ResidualView)
    assert whole.model
    assert whole.model.effects == ("rod_inertia",)
