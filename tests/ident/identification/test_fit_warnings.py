"""What a fit says against itself, in its assessment and in what is printed."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ident
from ident.identification.model import Model
from ident.output.assessment import warning_lines
from ident.uncertainty.fit_warning import FitWarning
from recordings.recording import Floats, Recording
from tests.ident import building


def warnings(model: Model) -> dict[str, FitWarning]:
    assert model.file.assessment is not None
    found = {each.kind: each for each in model.file.assessment.warnings if each.kind != "not-physical"}
    assert {each.sentence for each in found.values()} <= {*warning_lines(model.file.assessment)}
    assert str(model).splitlines() == [
        repr(model), *(each.sentence for each in [model.file.residual_test] if each),
        *warning_lines(model.file.assessment),
    ]  # fmt: skip
    assert all("\n" not in each.sentence for each in found.values())
    return found


def made(make: Callable[..., Recording], *arguments: Any, **options: Any) -> Recording:
    """A recording of a delta robot that is in no file."""
    return replace(make(*arguments, **options), known_digest=str(arguments))


def test_a_right_model_has_nothing_against_it() -> None:
    recordings = (building.record(noise=0.05, shape=shape, seed=shape) for shape in (0, 1))
    train, held_out = recordings
    assert not warnings(ident.fit(train, validate=held_out, method="wls"))


def test_a_parameter_at_its_bound_is_named(make: Callable[..., Recording]) -> None:
    """These recordings are of forearms without mass."""
    found = warnings(ident.fit(made(make, noise=0.01), method="lad"))
    assert found["at-bound"].name == "rod_inertia.m_d"
    assert "rod_inertia.m_d = 0 kg" in found["at-bound"].sentence


def test_a_mass_that_may_be_zero_is_not_determined(make: Callable[..., Recording], truth: Floats) -> None:
    light = truth * np.where(np.arange(len(truth)) == 0, 1e-3, 1.0)
    found = warnings(ident.fit(made(make, parameters=light, noise=0.3), method="wls", without=["rod_inertia"]))
    assert found["not-determined"].name == "m_p"


def test_intervals_are_conditional_while_structure_is_left() -> None:
    recording = building.record(noise=0.05, extra=building.drag)
    assert (
        "may lie far outside of the intervals" in warnings(ident.fit(recording, method="wls"))["conditional"].sentence
    )
    repaired = ident.fit(recording, method="wls", effects=["quadratic_friction"])
    assert "conditional" not in warnings(repaired)


def test_an_error_larger_than_the_torque_is_of_another_robot(make: Callable[..., Recording], truth: Floats) -> None:
    other = made(make, "fig5b", parameters=truth / 5, noise=0.01)
    found = warnings(ident.fit(made(make, noise=0.01), validate=other, method="wls"))
    assert "another robot, payload or rig file?" in found["held-out"].sentence


@pytest.mark.parametrize("missing", [4, 0])
def test_a_noise_floor_of_missing_samples_is_no_noise(missing: int) -> None:
    """The same noise, 10 % of the torque, with every sample is noise."""
    recording = building.record(noise=0.8)
    position = recording.position.copy()
    position[500 : 500 + missing] = np.nan
    model = ident.fit(replace(recording, position=position), method="wls")
    assert model.file.residual_test is not None
    assert model.file.residual_test.verdict == "within-noise"
    found = warnings(model)
    assert ("noise-floor" in found) == bool(missing)
    if missing:
        assert found["noise-floor"].sentence.startswith("4 samples are missing: ")


def stribeck(motion: Any) -> Floats:
    return np.sign(motion.velocity) * np.exp(-((motion.velocity / 0.3) ** 2))


def test_searched_parameters_have_intervals_and_covariance_as_in_a_diagnosis(tmp_path: Path) -> None:
    recordings = (building.record(noise=0.05, extra=stribeck, shape=shape, seed=shape) for shape in (0, 1))
    train, held_out = recordings
    model = ident.fit(train, validate=held_out, method="wls", effects=["stribeck"])
    speed = model.parameters["stribeck.v_s"]
    assert speed.ci95 is not None
    assert speed.ci95[0] < 0.3 < speed.ci95[1]
    assert np.ptp(speed.ci95) < 0.1
    assert np.isfinite(model.covariance).all()
    assert model.covariance[-1, -1] == pytest.approx((speed.std or 0.0) ** 2)
    diagnosed = ident.diagnose(train, validate=held_out, only=["stribeck"]).model
    assert np.isfinite(diagnosed.covariance).all()
    assert np.ptp(diagnosed.parameters["stribeck.v_s"].ci95 or ()) == pytest.approx(np.ptp(speed.ci95), rel=0.5)
    for name, parameter in model.parameters.items():
        ratio = (parameter.std or 0.0) / (diagnosed.parameters[name].std or 1.0)
        assert 0.5 < ratio < 2.0, name
    model.save(tmp_path / "m.json")
    assert ident.load_model(tmp_path / "m.json").parameters["stribeck.v_s"].ci95 == speed.ci95
