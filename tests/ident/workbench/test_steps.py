"""The way through the page."""

from types import SimpleNamespace
from typing import Any, cast

from ident.workbench.session import DisplaySettings
from ident.workbench.steps import next_step, steps


def session(**parts: Any) -> Any:
    selection = {"step_list": None, "residuals": None, "within_noise": False}
    export = SimpleNamespace(saved_name=lambda model: "m.json" if parts.get("saved") else None)
    return SimpleNamespace(
        recordings=SimpleNamespace(train=parts.get("train")),
        selection=SimpleNamespace(**{name: parts.get(name, value) for name, value in selection.items()}),
        display=DisplaySettings(visited=parts.get("visited", set())),
        export=export,
    )


def step_list(*effects: str) -> Any:
    terms = [(name, (1,)) for name in ("rod_inertia", *effects)]
    return SimpleNamespace(mandatory=("rod_inertia",), steps=[SimpleNamespace(terms=terms)])


def test_each_step_leads_to_the_next() -> None:
    analysed = SimpleNamespace(model=None)
    fitted = {"train": "a.mcap", "step_list": step_list(), "residuals": analysed}
    assert next_step(session()) == "data"
    assert next_step(session(train="a.mcap")) == "model"
    assert next_step(session(train="a.mcap", step_list=step_list())) == "residuals"
    assert next_step(session(**fitted)) == "residuals"
    assert next_step(session(**fitted, visited={"residuals"})) == "missing"
    added = {**fitted, "step_list": step_list("stribeck")}
    assert next_step(session(**added)) == "missing", "more is missing"
    at_floor = {**added, "within_noise": True}
    assert next_step(session(**at_floor)) == "export"
    assert next_step(session(**at_floor, saved=True)) is None


def test_first_model_within_the_noise_needs_no_effect() -> None:
    fitted = {
        "train": "a.mcap",
        "step_list": step_list(),
        "residuals": SimpleNamespace(model=None),
        "within_noise": True,
    }
    assert [step.done for step in steps(cast(Any, session(**fitted)))] == [True, True, True, True, False]
