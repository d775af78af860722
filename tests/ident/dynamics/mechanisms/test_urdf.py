"""Trees of links: torque by Newton's laws, base parameters, couplings, fixed joints, and what is refused."""

import copy
import importlib.util
import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ident.dynamics import mechanisms
from ident.dynamics.effects.library import load
from ident.dynamics.mechanisms import RigidMechanism
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.motion import Motion
from recordings.description import frames
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig, load_rig

pytest.importorskip("pinocchio")

G = 9.81
INERTIAL = (
    '<inertial><mass value="{}"/><origin xyz="{}"/>'
    '<inertia ixx="0.03" ixy="0.001" ixz="0.002" iyy="0.04" iyz="-0.001" izz="0.02"/></inertial>'
)


def urdf(*, inertial: bool = True, kinds: tuple[str, ...] = ("continuous", "prismatic", "revolute")) -> str:
    """An arm that swings about the horizontal y, a slide along its x, and a hand that turns about the slide's z."""
    axes, places = ("0 1 0", "1 0 0", "0 0 1"), ("0 0 0.5", "0.3 0 0", "0.1 0 0.2")
    links = [
        f'<link name="l{i}">{INERTIAL.format(1.5 / i, "0.1 0.02 0.03") if inertial else ""}</link>' for i in (1, 2, 3)
    ]
    joints = [
        f'<joint name="j{i}" type="{kind}"><parent link="{f"l{i - 1}" if i > 1 else "base"}"/><child link="l{i}"/>'
        f'<origin xyz="{place}" rpy="0 0 0"/><axis xyz="{axis}"/></joint>'
        for i, (kind, axis, place) in enumerate(zip(kinds, axes, places, strict=True), start=1)
    ]
    return f'<robot name="r"><link name="base"/>{"".join(links + joints)}</robot>'


def rig(text: str = "", joints: tuple[str, ...] = ("j1", "j2", "j3"), **keys: Any) -> Rig:
    return Rig(name="r", mechanism="urdf", urdf=text or urdf(), joints=joints, **keys)


def motion(dof: int = 3, seed: int = 1) -> Motion:
    position, velocity, acceleration = np.random.default_rng(seed).uniform(-1, 1, (3, 40, dof))
    return Motion(position, velocity, acceleration, np.sign(velocity))


def torque(mechanism: RigidMechanism, at: Motion, **values: float) -> Floats:
    known = dict.fromkeys((parameter.name for parameter in mechanism.parameters), 0.0)
    assert values.keys() <= known.keys()
    computed: Floats = mechanism.regressor(at) @ np.array(list((known | values).values()))
    return computed


def fitted(mechanism: RigidMechanism, at: Motion, measured: Floats) -> Floats:
    """Parameters by least squares."""
    regressor = mechanism.regressor(at)
    rows = regressor.reshape(-1, regressor.shape[2])
    assert np.linalg.matrix_rank(rows / np.linalg.norm(rows, axis=0)) == rows.shape[1]
    values: Floats = np.linalg.lstsq(rows, measured.ravel(), rcond=None)[0]
    return values


def test_single_pendulum_obeys_newton() -> None:
    pendulum = mechanisms.create(rig(joints=("j1",), fixed={"j2": 0.2}, motor_inertia=False))
    assert [parameter.name for parameter in pendulum.parameters] == ["mx_1", "mz_1", "Iyy_1", "c_v1", "c_c1", "c_o1"]
    at = motion(1)
    q, v, a = at.position, at.velocity, at.acceleration
    computed = torque(pendulum, at, mx_1=0.5, mz_1=0.25, Iyy_1=0.7, c_v1=0.3, c_c1=0.4, c_o1=0.1)
    held = -G * (0.5 * np.cos(q) + 0.25 * np.sin(q))
    np.testing.assert_allclose(computed, 0.7 * a + held + 0.3 * v + 0.4 * np.sign(v) + 0.1, rtol=1e-9)


def test_base_parameters_span_the_torque_of_any_links_and_no_fewer_do() -> None:
    robot = mechanisms.create(rig(payload={"mass": 0.5, "com": (0.0, 0.1, 0.0)}, gravity=(0.0, 3.0, -9.0)))
    at, elsewhere = motion(), motion(seed=2)
    nominal, there = robot.nominal_torque(at), robot.nominal_torque(elsewhere)
    assert nominal is not None
    assert there is not None
    values = fitted(robot, at, nominal)
    np.testing.assert_allclose(robot.regressor(elsewhere) @ values, there, atol=1e-8 * np.abs(there).max())


def test_combinations_say_what_stands_in_a_base_parameter() -> None:
    """The fitted base parameters are the sums that their meanings state, of the links' own values."""
    robot = mechanisms.create(rig(urdf(), motor_inertia=False))
    values = fitted(robot, motion(), robot.nominal_torque(motion()))  # type: ignore[arg-type]
    masses = {f"m_{i}": 1.5 / i for i in (1, 2, 3)}
    first = {f"{name}_{i}": 1.5 / i * c for i in (1, 2, 3) for name, c in (("mx", 0.1), ("my", 0.02), ("mz", 0.03))}
    by_name = {parameter.name: (parameter, value) for parameter, value in zip(robot.parameters, values, strict=True)}
    parameter, value = by_name["mx_1+"] if "mx_1+" in by_name else by_name["mx_1"]
    terms = parameter.meaning.replace("- ", "+ -").split(" + ") if "+" in parameter.name else [parameter.name]
    known = masses | first
    total = 0.0
    for term in terms:
        factor, _, name = term.rpartition(" ")
        total += (float(factor) if factor else 1.0) * (-1 if name.startswith("-") else 1) * known[name.lstrip("-")]
    assert value == pytest.approx(total, rel=1e-3)


def test_motor_that_turns_with_another_joint_acts_on_both() -> None:
    coupled = mechanisms.create(rig(couplings=({"of": 3, "by": 1, "ratio": 2.0},)))
    at = motion()
    speed = at.velocity[:, 2] + 2.0 * at.velocity[:, 0]
    for values, signal in (({"c_v3": 1.0}, speed), ({"c_c3": 1.0}, np.sign(speed))):
        expected = np.stack([2.0 * signal, 0 * signal, signal], axis=1)
        np.testing.assert_allclose(torque(coupled, at, **values), expected, atol=1e-12)
    inertia = torque(coupled, at, Im_3=1.0)
    acceleration = at.acceleration[:, 2] + 2.0 * at.acceleration[:, 0]
    np.testing.assert_allclose(inertia[:, [0, 2]], np.stack([2 * acceleration, acceleration], axis=1), atol=1e-12)


def test_direction_of_a_coupled_motor_is_averaged_over_the_sample_of_its_reversal() -> None:
    coupled = mechanisms.create(rig(couplings=({"of": 3, "by": 1},)))
    velocity, acceleration = np.array([[0.1, 1.0, -0.05]]), np.array([[2.0, 0.0, 0.0]])
    at = Motion(np.zeros((1, 3)), velocity, acceleration, np.sign(velocity), sample_time=0.1)
    assert torque(coupled, at, c_c3=1.0)[0, 2] == pytest.approx(0.05 / 0.1)


def test_order_of_the_joints_is_the_users() -> None:
    at = motion()
    turned = Motion(*(signal[:, [2, 0, 1]] for signal in (at.position, at.velocity, at.acceleration, at.direction)))
    straight = mechanisms.create(rig()).nominal_torque(at)
    other = mechanisms.create(rig(joints=("j3", "j1", "j2"))).nominal_torque(turned)
    assert straight is not None
    np.testing.assert_allclose(other, straight[:, [2, 0, 1]], atol=1e-12)


def test_links_without_inertia_have_no_reference() -> None:
    assert mechanisms.create(rig(urdf(inertial=False))).nominal_torque(motion()) is None


NAMED = ("j1", "j2", "j3")
FLANGE = '<link name="{0}"/><joint name="{1}" type="fixed"><parent link="l3"/><child link="{0}"/>{2}</joint></robot>'
DECLARED = '<?xml version="1.0" encoding="{}"?>'


def with_flange(link: str, joint: str, axis: str = "") -> str:
    return urdf().replace("</robot>", FLANGE.format(link, joint, axis))


SPELLINGS: dict[str, tuple[str | bytes, tuple[str, ...]]] = {
    "continuous joints": (urdf(kinds=("revolute", "prismatic", "continuous")), NAMED),
    "a link as Pinocchio names its own": (urdf().replace('"base"', '"universe"'), NAMED),
    "a joint as Pinocchio names its own": (urdf().replace('"j1"', '"root_joint"'), ("root_joint", "j2", "j3")),
    "both": (urdf().replace('"base"', '"root_joint"').replace('"j1"', '"universe"'), ("universe", "j2", "j3")),
    "joints as links": (urdf().replace('name="j', 'name="l'), ("l1", "l2", "l3")),
    "joints as other links": (urdf().replace('"j1"', '"l2"').replace('"j2"', '"base"'), ("l2", "base", "j3")),
    "a fixed joint as its link": (with_flange("flange", "flange"), NAMED),
    "a fixed joint as a driven one's link": (with_flange("flange", "l3"), NAMED),
    "a fixed joint with an axis of zero": (with_flange("flange", "held", '<axis xyz="0 0 0"/>'), NAMED),
    "a fixed joint with an empty axis": (with_flange("flange", "held", "<axis/>"), NAMED),
    "a default namespace": (urdf().replace("<robot", '<robot xmlns="http://www.ros.org"'), NAMED),
    "a prefix for all": (re.sub("<(/?)", r"<\1u:", urdf()).replace("<u:robot", '<u:robot xmlns:u="u"'), NAMED),
    "namespaces of extensions": (
        urdf().replace("<robot", '<robot xmlns:d="d"').replace("</robot>", '<d:joint name="x"/></robot>'), NAMED
    ),
    "no name, another version": (urdf().replace(' name="r"', ' version="2.0"'), NAMED),
    "UTF-16 with its mark": ((DECLARED.format("utf-16") + urdf()).encode("utf-16"), NAMED),
    "UTF-16 with its mark alone": (urdf().encode("utf-16"), NAMED),
    "UTF-16 without it": ((DECLARED.format("utf-16") + urdf()).encode("utf-16-be"), NAMED),
    "UTF-8 with a mark": ((DECLARED.format("utf-8") + urdf()).encode("utf-8-sig"), NAMED),
    "Latin-1": ((DECLARED.format("iso-8859-1") + urdf().replace("j1", "Fuß")).encode("latin-1"), ("Fuß", "j2", "j3")),
    "UTF-8": (urdf().replace("j1", "関節"), ("関節", "j2", "j3")),
    "DOS": ((DECLARED.format("utf-8") + "\n" + urdf().replace(">", ">\n")).replace("\n", "\r\n"), NAMED),
}  # fmt: skip


@pytest.mark.parametrize("name", SPELLINGS)
def test_any_spelling_is_the_same_robot(name: str, tmp_path: Path) -> None:
    content, joints = SPELLINGS[name]
    (tmp_path / "r.urdf").write_bytes(content if isinstance(content, bytes) else content.encode())
    listed = ", ".join(f'"{joint}"' for joint in joints)
    (tmp_path / "r.toml").write_text(
        f'name = "r"\nmechanism = "urdf"\nurdf = "r.urdf"\njoints = [{listed}]\n', encoding="utf-8"
    )
    read = load_rig(tmp_path / "r.toml", driven=False)
    assert [frame.joint for frame in frames(read.urdf)][:3] == list(joints)
    other = mechanisms.create(Rig.model_validate_json(read.model_dump_json())).nominal_torque(motion())
    np.testing.assert_allclose(other, mechanisms.create(rig()).nominal_torque(motion()), rtol=1e-12)


def test_mechanism_can_be_pickled_and_copied() -> None:
    robot = mechanisms.create(rig())
    for other in (pickle.loads(pickle.dumps(robot)), copy.deepcopy(robot)):
        np.testing.assert_array_equal(other.regressor(motion()), robot.regressor(motion()))


def test_missing_package_is_named_with_its_command(monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "pinocchio" else find(name))
    with pytest.raises(BadInput, match=r"pip install 'delta-workbench\[urdf\]'"):
        mechanisms.create(rig(gravity=(0.0, 0.0, -1.0)))


def test_sideways_gravity_is_that_of_a_tilted_robot() -> None:
    level, tilted = (mechanisms.create(rig(gravity=gravity)) for gravity in ((0.0, 0.0, -9.8), (0.3, -0.2, -9.8)))
    assert isinstance(level, Urdf)
    at = motion()
    nominal, changed = level.nominal_torque(at), tilted.nominal_torque(at)
    assert nominal is not None
    assert changed is not None
    values = fitted(level, at, nominal)
    np.testing.assert_allclose(level.sideways(at, values) @ [0.3, -0.2], changed - nominal, atol=1e-9)


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), (0.0, 9.8, 0.0)])
def test_any_stated_gravity_has_two_directions_across_it(gravity: tuple[float, float, float]) -> None:
    robot = mechanisms.create(rig(gravity=gravity))
    assert isinstance(robot, Urdf)
    turned = robot.sideways(motion(), np.ones(len(robot.parameters)))
    assert np.linalg.matrix_rank(turned.reshape(-1, 2)) == 2


def test_mass_at_a_place_is_the_payload_there() -> None:
    place, at = (0.1, -0.2, 0.3), motion()
    bare = mechanisms.create(rig())
    loaded = mechanisms.create(rig(payload={"mass": 2.0, "com": place})).nominal_torque(at)
    empty = bare.nominal_torque(at)
    assert loaded is not None
    assert empty is not None
    np.testing.assert_allclose(2.0 * bare.torque_per_mass(at, place), loaded - empty, atol=1e-9)


def test_a_zero_that_the_links_replace_is_no_effect() -> None:
    """The first joint of an upright arm turns nothing that weight pulls at; the last one turns its own link alone."""
    zero = load("encoder_zero_offset")
    assert zero.possible_joints(rig()) == (0, 1)
    assert zero.possible_joints(rig(gravity=(0.0, -9.8, 0.0))) == (1,)


@pytest.mark.parametrize("inertial", [True, False])
@pytest.mark.parametrize("scale", [0.0, 1e-6, 1.0])
def test_torque_is_that_of_the_columns_whatever_the_parameters(inertial: bool, scale: float) -> None:
    mechanism, at = mechanisms.create(rig(urdf(inertial=inertial), motor_inertia=True)), motion()
    assert isinstance(mechanism, Urdf)
    values = scale * np.random.default_rng(2).normal(size=len(mechanism.parameters))
    difference = mechanism.torque(at, values) - mechanism.regressor(at) @ values
    assert np.abs(difference).max() <= 1e-9 * max(scale, 1e-3)
