"""Least squares in which links stay bodies: the best of all bodies, taken where the rows speak for it."""

import numpy as np
import pytest

import ident
from ident.basics import slicing
from ident.data.prepared_recording import PreparedRecording, prepare_all
from ident.data.row_weights import fitted_rows
from ident.dynamics import mechanisms
from ident.dynamics.bodies import link_parameters, pseudo_inertia
from ident.dynamics.mechanisms.urdf import Urdf
from ident.estimation import possible_links
from recordings.recording import Floats

pytest.importorskip("pinocchio")

from tests.ident import arms

ARM = arms.urdf(arms.SHOULDER)


def links(seed: int = 0) -> tuple[Urdf, Floats]:
    """An arm, and physical parameters of bodies that it could have."""
    mechanism = mechanisms.create(arms.rig(arms.without_masses(ARM)))
    assert isinstance(mechanism, Urdf)
    factor = np.random.default_rng(seed).normal(size=(3, 4, 4))
    return mechanism, np.concatenate([link_parameters(factor @ factor.swapaxes(1, 2)).ravel(), np.ones(3)])


def problem(mechanism: Urdf, seed: int = 0) -> tuple[Floats, Floats]:
    """Columns (r, f) of base parameters and of two others, of very different size, and parameters (f,) of bodies."""
    rng = np.random.default_rng(seed)
    size = np.append(10.0 ** rng.uniform(-3, 3, len(mechanism.base.columns)), [1e3, 1e-3])
    base = mechanism.base.combination @ links(seed)[1]
    return rng.normal(size=(300, len(size))) * size, np.append(base, rng.normal(size=2) / size[-2:])


def test_parameters_of_bodies_are_found_from_anywhere() -> None:
    mechanism, _ = links()
    columns, true = problem(mechanism)
    now = true[:-2] + np.random.default_rng(1).normal(size=len(true) - 2)
    residual = columns @ true - columns[:, :-2] @ now
    step = possible_links.step(mechanism, columns.T @ columns, columns.T @ residual, now)
    error = columns @ (np.append(now, [0, 0]) + step - true)
    assert np.linalg.norm(error) < 1e-4 * np.linalg.norm(columns @ true)


def test_no_other_bodies_are_nearer() -> None:
    """The objective grows towards any other bodies, and is convex."""
    mechanism, _ = links()
    rng = np.random.default_rng(2)
    root, target = rng.normal(size=(2, 40, len(mechanism.base.columns)))[0], rng.normal(size=40)
    best = mechanism.nearest_bodies(root, target)
    assert np.linalg.eigvalsh(pseudo_inertia(best[:30].reshape(3, 10))).min() > -1e-6
    assert best[30:].min() > -1e-6

    def error(physical: Floats) -> float:
        return float(np.linalg.norm(root @ mechanism.base.combination @ physical - target))

    others = [links(seed)[1] for seed in range(40)]
    assert min(error(best + share * (other - best)) for other in others for share in (1e-3, 1.0)) > error(best) - 1e-6


def prepared(gain: Floats | float, seconds: float) -> PreparedRecording:
    recording = arms.record(ARM, arms.without_masses(ARM), gain=gain)
    return prepare_all([slicing.along_time(recording, recording.time < seconds)], "parallel", None)[0]


def test_a_short_motion_speaks_for_bodies_unless_the_gains_of_joints_are_wrong() -> None:
    for gain, expected in ((1.0, True), (np.array([1.0, 0.5, 1.7]), False)):
        each = prepared(gain, 2.0)
        fitted = fitted_rows([each])
        (bound,) = possible_links.bound_to_bodies([each], fitted.rows, fitted.weights)
        assert isinstance(bound.mechanism, Urdf)
        assert bound.mechanism.bound_to_bodies == expected


def test_fit_and_diagnosis_are_bound_alike_and_say_so() -> None:
    train, other = (arms.record(arms.urdf(arms.LIFTING), seed=seed) for seed in (1, 2))
    fitted, diagnosis = ident.fit(train, validate=other), ident.diagnose(train, validate=other)
    of_fit, of_diagnosis = (each.file.method.diagnostics for each in (fitted, diagnosis.model))
    assert of_fit["bound_to_bodies"] == of_diagnosis["bound_to_bodies"]
    first = diagnosis.document.steps[0].held_out_rms
    np.testing.assert_allclose(fitted.file.validate_.fitted.rms, first, rtol=1e-3)  # type: ignore[union-attr]
