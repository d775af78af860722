"""The mechanism "urdf" in a rig file: its text travels, and what cannot be right is explained."""

from pathlib import Path

import pytest

from recordings.errors import BadInput
from recordings.rig import Rig, load_rig
from recordings.urdf_joints import read_joints

ARM = """<robot name="arm">
  <link name="base"/><link name="upper"/><link name="slide"/><link name="hand"/><link name="finger"/>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <joint name="rail" type="prismatic"><parent link="upper"/><child link="slide"/></joint>
  <joint name="wrist" type="fixed"><parent link="slide"/><child link="hand"/></joint>
  <joint name="grip" type="revolute"><parent link="hand"/><child link="finger"/></joint>
</robot>"""
RIG = 'name = "r"\nmechanism = "urdf"\nurdf = "arm.urdf"\n'
DRIVEN = RIG + 'joints = ["rail", "shoulder"]\n'


def mimicking(joint: str) -> str:
    """The arm with a grip that mimics a `joint`."""
    return ARM.replace('link="finger"/></joint>', f'link="finger"/><mimic joint="{joint}"/></joint>')


def load(folder: Path, rig: str = DRIVEN, urdf: str | bytes = ARM) -> Rig:
    (folder / "arm.urdf").write_bytes(urdf if isinstance(urdf, bytes) else urdf.encode())
    (folder / "rig.toml").write_text(rig, encoding="utf-8")
    return load_rig(folder / "rig.toml", driven=False)


def test_rig_holds_the_text_and_needs_no_file_afterwards(tmp_path: Path) -> None:
    rig = load(tmp_path, DRIVEN + "fixed = { grip = 0.4 }\npayload = { mass = 1.0, com = [0, 0, 0.1] }\n")
    (tmp_path / "arm.urdf").unlink()
    assert Rig.model_validate_json(rig.model_dump_json()) == rig
    assert (rig.joint_types, rig.effort_units, rig.torque.gain) == (
        ("prismatic", "revolute"),
        ("N", "N m"),
        (1.0, 1.0),
    )
    assert rig.urdf == ARM
    assert "sha256" in rig.properties["urdf"]


@pytest.mark.parametrize(
    ("rig", "urdf", "reason"),
    [
        (DRIVEN, ARM[:-1], "XML expected, unclosed token"),
        (DRIVEN, "<model/>", "a <robot> expected, <model> found"),
        (
            DRIVEN,
            ARM.replace("<robot", '<robot xmlns:xacro="http://wiki.ros.org/xacro"').replace(
                '<link name="base"/>', '<link name="base"/><xacro:arm/>'
            ),
            "xacro found; run `xacro",
        ),
        (DRIVEN, ARM.replace("continuous", "floating"), "joint shoulder is floating: .*make the joint fixed"),
        (DRIVEN, ARM.replace("continuous", "planar"), "joint shoulder is planar: .*two prismatic"),
        (DRIVEN, ARM.replace("continuous", "screw"), "joint shoulder: type revolute, .* expected, screw found"),
        (
            DRIVEN,
            ARM.replace('child link="hand"', 'child link="foot"'),
            "joint wrist: .*among the links .*'foot' found",
        ),
        (
            DRIVEN,
            ARM.replace('parent link="base"', 'parent link="finger"'),
            "lead round in a circle",
        ),
        (DRIVEN, ARM.replace('child link="hand"', 'child link="upper"'), "a tree expected, but link upper has two"),
        (DRIVEN, ARM.replace('<link name="base"/>', '<link name="base"/><link name="x"/>'), "base, x found"),
        (DRIVEN, ARM.replace('joint name="grip"', 'joint name="rail"'), "joint rail stands 2 times"),
        (RIG + 'joints = ["grip"]\n', mimicking("rail"), "grip mimics rail; take grip out of joints"),
        (
            DRIVEN,
            mimicking("thumb"),
            "<mimic> of a joint expected, but that of grip leads to 'thumb', which is none",
        ),
        (DRIVEN, mimicking("grip"), "that of grip leads round in a circle"),
        (DRIVEN, mimicking('rail" offset="far'), "joint grip: <mimic offset> of 1 numbers expected, 'far' found"),
        (
            DRIVEN,
            ARM.replace("0 1 0", "0 one 0"),
            "joint shoulder: <axis xyz> of 3 numbers expected, '0 one 0' found",
        ),
        (DRIVEN, ARM.replace("0 1 0", "0 0 0"), "joint shoulder: an <axis> with a direction expected, 0 0 0 found"),
        (
            DRIVEN,
            ARM.replace('<link name="hand"/>', '<link name="hand"><inertial><mass value="1"/></inertial></link>'),
            "link hand: <inertia ixx .*> of <inertial> expected",
        ),
        (RIG, ARM, "joints: names of the driven joints expected, none found; the URDF has shoulder, rail, grip"),
        (
            RIG + 'joints = ["elbow"]\n',
            ARM,
            r"joints: .*\(shoulder, rail, grip\), 'elbow' found, no joint of that name",
        ),
        (RIG + 'joints = ["wrist"]\n', ARM, "joints: movable joints .*'wrist' found, a fixed one"),
        (DRIVEN + "fixed = { rail = 0.1 }\n", ARM, "every joint once in joints or fixed expected, 'rail' twice"),
        (DRIVEN + "couplings = [{ of = 2, by = 3 }]\n", ARM, "two different joints from 1 to 2 expected.*by = 3"),
        (DRIVEN + "start = { elbow = 0.1 }\n", ARM, r"start: movable joints .*'elbow' found"),
        (DRIVEN + 'loops = [{ a = "hand", b = "foot" }]\n', ARM, "loops: links of the URDF .*, 'foot' found"),
        (DRIVEN + 'tool = "foot"\n', ARM, "tool: links of the URDF .*, 'foot' found"),
        (DRIVEN + 'loops = [{ a = "hand", b = "upper" }]\n', ARM, "loops: joints within them .*, none found"),
        (
            DRIVEN + 'loops = [{ a = "finger", b = "base" }]\n',
            ARM.replace(
                "</robot>",
                """<link name="tip"/><joint name="bend" type="revolute"><parent link="finger"/>
                <child link="tip"/><mimic joint="grip"/></joint></robot>""",
            ),
            "bend mimics grip; remove <mimic> and let a loop hold bend, or name it in fixed",
        ),
        ('name = "r"\nmechanism = "urdf"\n', ARM, 'mechanism "urdf" needs the key urdf'),
        ('name = "r"\ngravity = [0.0, 0.0, 0.0]\n', ARM, 'gravity belongs to the mechanism "urdf", "delta" found'),
        (DRIVEN, ARM.encode("utf-16")[:-40], "arm.urdf: XML in UTF-8 expected, .* found; save it as UTF-8"),
        (DRIVEN, b"\xff" + ARM.encode(), "XML in UTF-8 expected, not well-formed"),
        (DRIVEN, b'<?xml version="1.0" encoding="ebcdic-9"?>\xff', "XML in UTF-8 expected, unknown encoding"),
        (DRIVEN.replace("arm.urdf", "leg.urdf"), ARM, "'urdf' of the rig file: .*leg.urdf does not exist"),
    ],
)
def test_what_cannot_be_right_is_explained(tmp_path: Path, rig: str, urdf: str | bytes, reason: str) -> None:
    with pytest.raises(BadInput, match=reason):
        load(tmp_path, rig, urdf)


@pytest.mark.parametrize(
    ("limit", "expected"),
    [
        ('<limit lower="-1.5" upper="2" effort="9"/>', (-1.5, 2.0)),
        ('<limit upper="2"/>', (0.0, 2.0)),
        ('<limit lower="0" upper="0"/>', None),
        ('<limit lower="wide" upper="2"/>', None),
        ("", None),
    ],
)
def test_limits_are_those_that_leave_a_way(limit: str, expected: tuple[float, float] | None) -> None:
    text = ARM.replace('<child link="finger"/>', f'<child link="finger"/>{limit}')
    assert {joint.name: joint.limits for joint in read_joints(text)}["grip"] == expected
