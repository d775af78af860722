"""A robot of a URDF from a table to a model: import, fit, model file, evaluation, comparison, diagnosis."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.identification.model import Model
from recordings.errors import BadInput
from recordings.importing import Description, import_data
from recordings.recording import Floats
from recordings.rig import load_rig

pinocchio = pytest.importorskip("pinocchio")

INERTIAL = (
    '<inertial><origin xyz="0.2 0.01 0.05"/><mass value="2"/>'
    '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial>'
)
URDF = f"""<robot name="arm">
  <link name="base"/><link name="l1">{INERTIAL}</link>
  <link name="l2">{INERTIAL}</link><link name="l3">{INERTIAL}</link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/></joint>
  <joint name="lift" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0.3 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="100" velocity="5"/></joint>
  <joint name="push" type="prismatic"><parent link="l2"/><child link="l3"/><origin xyz="0.4 0 0"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="100" velocity="5"/></joint>
</robot>"""
RIG = 'name = "arm"\nmechanism = "urdf"\nurdf = "arm.urdf"\njoints = ["turn", "lift", "push"]\n'
VISCOUS, COULOMB, OFFSET = np.array([0.4, 0.6, 3.0]), np.array([0.5, 0.8, 4.0]), np.array([0.2, -0.3, 1.0])
STRIBECK, SPEED = 0.8, 0.25


def motion(seed: int, seconds: float = 12.0, rate: float = 250.0) -> tuple[Floats, Floats, Floats, Floats]:
    """Time (n,), position, velocity and acceleration (n, 3) of sums of sines."""
    generator, t = np.random.default_rng(seed), np.arange(0, seconds, 1 / rate)[:, None]
    omega = 2 * np.pi * np.array([0.2, 0.5, 0.9, 1.3])[:, None] * generator.uniform(0.9, 1.1, (4, 3))
    phase, size = generator.uniform(0, 2 * np.pi, (4, 3)), np.array([0.5, 0.4, 0.08]) / np.array([[1], [2], [3], [4]])
    angle = omega[:, None] * t + phase[:, None]
    position, velocity, acceleration = (
        (factor * size[:, None] * shape).sum(axis=0)
        for factor, shape in (
            (np.ones((4, 1, 3)), np.sin(angle)),
            (omega[:, None], np.cos(angle)),
            (-(omega[:, None] ** 2), np.sin(angle)),
        )
    )
    return t[:, 0], position, velocity, acceleration


def true_torque(q: Floats, v: Floats, a: Floats, stribeck: float = 0.0) -> Floats:
    """Torque (n, 3) by Pinocchio's own inverse dynamics, with friction."""
    model = pinocchio.buildModelFromXML(
        URDF.replace("continuous", "revolute").replace(
            '<axis xyz="0 0 1"/>', '<axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="100" velocity="5"/>'
        )
    )
    data = model.createData()
    rigid = np.array([pinocchio.rnea(model, data, *at) for at in zip(q, v, a, strict=True)])
    falling = np.array([0.0, stribeck, 0.0]) * np.exp(-((v / SPEED) ** 2)) * np.sign(v)
    torque: Floats = rigid + VISCOUS * v + COULOMB * np.sign(v) + OFFSET + falling
    return torque


def record(folder: Path, name: str, seed: int, stribeck: float = 0.0) -> Path:
    time, *at = motion(seed)
    effort = true_torque(*at, stribeck)
    effort = effort + np.random.default_rng(seed).normal(0, 0.01, effort.shape) * effort.std(axis=0)
    header = ",".join(["time", *(f"{kind}_{j}" for kind in ("position", "effort") for j in (1, 2, 3))])
    table = np.column_stack([time, at[0], effort])
    np.savetxt(folder / f"{name}.csv", table, "%.7f", ",", header=header, comments="")
    import_data(
        folder / f"{name}.csv", folder / f"{name}.mcap", Description(rig=load_rig(folder / "rig.toml", driven=False))
    )
    return folder / f"{name}.mcap"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("arm")
    (path / "arm.urdf").write_text(URDF, encoding="utf-8")
    (path / "rig.toml").write_text(RIG, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def recordings(folder: Path) -> Sequence[Path]:
    paths = [record(folder, "train", 1), record(folder, "held_out", 2)]
    (folder / "arm.urdf").unlink()  # a recording opens on another machine
    return paths


@pytest.fixture(scope="module")
def model(recordings: Sequence[Path], folder: Path) -> Model:
    ident.fit([recordings[0]], validate=recordings[1], method="wls").save(folder / "model.json")
    return ident.load_model(folder / "model.json")


def test_loaded_model_has_the_torque_of_the_true_robot(model: Model) -> None:
    _, *at = motion(3)
    truth = true_torque(*at)
    error = np.sqrt(np.mean((model.torque(*at) - truth) ** 2, axis=0))
    assert (error < 0.01 * truth.std(axis=0)).all()
    for j, friction in enumerate(COULOMB, start=1):
        assert model.parameters[f"c_c{j}"].value == pytest.approx(friction, rel=0.1)
    assert any("+" in parameter.meaning for parameter in model.file.parameters if parameter.name.endswith("+"))


def test_the_swarm_fits_a_tree_of_links_only_where_it_is_asked_for(recordings: Sequence[Path]) -> None:
    assert ident.fit(recordings[0]).file.method.name == "wls"
    assert ident.fit(recordings[0], settings={"iterations": 1}).file.method.name == "pso"


def test_terms_add_up_and_acceleration_is_the_inverse_of_torque(model: Model) -> None:
    _, *at = (signal[:50] for signal in motion(4))
    q, v, a = at
    torque = model.torque(q, v, a)
    np.testing.assert_allclose(sum(model.terms(q, v, a).values()), torque, atol=1e-9)
    np.testing.assert_allclose(model.acceleration(q, v, torque), a, atol=1e-6)
    terms = model.terms(q, v, a)
    inertia = np.einsum("nij,nj->ni", model.inertia(q), a)
    np.testing.assert_allclose(terms["inertia"] + terms["inertia_coupling"], inertia, atol=1e-8)


def test_comparison_scores_every_joint(model: Model, recordings: Sequence[Path]) -> None:
    comparison = ident.compare(model, [recordings[1]])
    assert [joint.summary.share < 0.03 for joint in comparison.joints] == [True] * 3


@pytest.mark.slow
def test_diagnosis_names_what_a_joint_has_beyond_its_base_model(folder: Path, recordings: Sequence[Path]) -> None:
    (folder / "arm.urdf").write_text(URDF, encoding="utf-8")
    paths = [record(folder, f"hidden_{seed}", seed, STRIBECK) for seed in (5, 6)]
    diagnosis = ident.diagnose([paths[0]], validate=[paths[1]])
    assert [(finding.effect, finding.joints) for finding in diagnosis.findings] == [("stribeck", (2,))]
    assert diagnosis.model.parameters["stribeck.a2"].value == pytest.approx(STRIBECK, rel=0.2)


def test_another_robot_is_refused_by_its_digest(model: Model, folder: Path) -> None:
    (folder / "arm.urdf").write_text(URDF.replace("0.4 0 0", "0.5 0 0"), encoding="utf-8")
    with pytest.raises(BadInput, match=r"urdf is sha256:.* in the model, sha256:"):
        ident.compare(model, [record(folder, "longer", 7)])
