"""The climb by hand, without a page: the same models and numbers as `ident diagnose`."""

from pathlib import Path

import numpy as np
import pytest

from ident.workbench import views
from ident.workbench.engine import Engine
from ident.workbench.region import special
from ident.workbench.script import script
from recordings.errors import BadInput

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
    (view,) = engine.look(TRAIN)
    assert isinstance(view, views.RecordingView)
    assert dict(view.quality)["Drives"].startswith("simulated")
    assert view.signals["position"][1].shape == (len(view.time), 3)
    assert not view.warnings


def test_fit_add_undo(engine: Engine) -> None:
    ladder, series, choice, failing = engine.fit(TRAIN, VALIDATE)
    assert isinstance(ladder, views.LadderView)
    assert [rung.label for rung in ladder.rungs] == ["base model", "+ rod_inertia"]
    assert isinstance(series, tuple)
    assert [one.held_out for one in series] == [False, True]
    for number, one in enumerate(series):
        rms = np.sqrt(np.nanmean(one.residual**2, axis=0))
        entry = ladder.rungs[-1].entry
        np.testing.assert_allclose(rms, (entry.train_rms, entry.validate_rms)[number])
    assert isinstance(failing, views.Failing)
    assert failing.document["recordings"] == ["fig5b.mcap"]
    assert isinstance(choice, views.Choice)
    gains = [one.gain for one in choice.candidates]
    assert gains == sorted(gains, reverse=True)

    added = ladder_of(engine.add(choice.candidates[0].name))
    assert len(added.rungs) == 3
    assert np.sum(np.square(added.rungs[2].entry.train_rms)) < np.sum(np.square(added.rungs[1].entry.train_rms))
    assert f"--only {choice.candidates[0].name}" in script(added, "m.json")
    assert "ident fit" in script(ladder, "m.json")
    assert "--with rod_inertia" in script(ladder, "m.json")
    bare = ladder_of(engine.remove(0))
    assert bare.rungs[-1].label == "− rod_inertia"
    assert "--with rod_inertia" not in script(bare, "m.json")
    next(engine.undo())
    assert added.can_undo
    assert ladder_of(engine.undo()).rungs == ladder.rungs


def test_a_process_that_was_replaced_goes_on_where_the_other_was(engine: Engine) -> None:
    ladder = ladder_of(engine.fit(TRAIN, None))
    kept = [(rung.label, rung.terms, rung.x) for rung in ladder.rungs]
    again = ladder_of(Engine(lambda text: None).restore(TRAIN, None, kept))
    for before, after in zip(ladder.rungs, again.rungs, strict=True):
        assert after.label == before.label
        np.testing.assert_allclose(after.entry.train_rms, before.entry.train_rms, rtol=1e-6)
        np.testing.assert_allclose(after.entry.validate_rms, before.entry.validate_rms, rtol=1e-6)


def test_what_cannot_be_done_is_said(engine: Engine) -> None:
    with pytest.raises(BadInput, match="Fit first"):
        next(engine.add("stribeck"))
    next(engine.fit(TRAIN, None))
    with pytest.raises(BadInput, match="another card"):
        next(engine.add("__import__('os')"))
    with pytest.raises(BadInput, match="number 8"):
        next(engine.remove(7))


def test_what_is_special_about_a_part() -> None:
    time = np.arange(400) / 100
    speed = np.where(time < 1, 0.1, 1.0)[:, None]
    series = views.Series(
        name="made",
        held_out=False,
        time=time,
        measured=np.where(time < 1, 0.5, 0.1)[:, None] * np.cos(40 * time)[:, None],
        computed=np.zeros((400, 1)),
        velocity=speed,
        position=time[:, None],
        phase=np.where(time < 1, "reversal", "cruise")[:, None],
        cycle=np.where(time < 2, 1, 2),
        counted=np.ones((400, 1), bool),
    )
    told = " ".join(special(series, 0, 0.0, 0.99))
    assert "5.0 times that of the rest" in told
    assert "slower than usual" in told
    assert "reversal 100 % (usually 25 %)" in told
    assert "Cycle 1." in told
    assert "Too little" in special(series, 0, 0.0, 0.01)[0]
    assert "all of it" in special(series, 0, 0.0, 9.0)[0]
