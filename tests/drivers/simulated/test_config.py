from pathlib import Path

import pytest

from drivers.simulated.config import EffectSpec, Links, load_sim
from drivers.simulated.habits import Habits, habits_from
from recordings.errors import BadInput


def _file(folder: Path, text: str) -> Path:
    path = folder / "sim.toml"
    path.write_text(text)
    return path


def test_default_shoulder_inertia_equals_the_papers() -> None:
    links = Links()
    assert links.arm_inertia + links.arm_mass * links.arm_com**2 + links.motor_inertia == pytest.approx(
        0.2156, abs=5e-5
    )


def test_file_is_read(tmp_path: Path) -> None:
    text = """
    voltage_noise = 0.002
    torque_gain = [1.1, 1.0, 0.9]
    [links]
    platform_mass = 0.5
    [friction]
    coulomb = [0, 0, 0]
    [[effects]]
    name = "stribeck"
    joints = [1, 3]
    size = 0.03
    parameters = { v_s = 1 }
    """
    config = load_sim(_file(tmp_path, text))
    assert config.links.platform_mass == 0.5
    assert config.torque_gain == (1.1, 1.0, 0.9)
    assert config.friction.coulomb == (0.0, 0.0, 0.0)
    assert config.effects == (EffectSpec(name="stribeck", joints=(1, 3), size=0.03, parameters={"v_s": 1.0}),)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("voltage_nois = 0.1", "unknown key 'voltage_nois'"),
        ("voltage_noise = -1", "voltage_noise"),
        ("[links]\nplatform_mass = 0", "links.platform_mass"),
        ("[[effects]]\njoints = [1]", "effects.0.name"),
        ('[[effects]]\nname = "cogging"\njoints = [4]', "effects.0.joints.0"),
        ('[[effects]]\nname = "cogging"\nsize = 3', "effects.0.size"),
    ],
)
def test_bad_file_is_explained(tmp_path: Path, text: str, complaint: str) -> None:
    with pytest.raises(BadInput, match=complaint):
        load_sim(_file(tmp_path, text))


def test_settings_of_the_command_line_are_toml() -> None:
    habits = habits_from(["fault_reset = 0.1", 'allowed."605A"=[6]', 'refuse_write=["1006"]'], Habits(enabling=0.2))
    assert habits == Habits(fault_reset=0.1, allowed={"605A": (6,)}, refuse_write=("1006",), enabling=0.2)


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        (["fault_reset"], "KEY=VALUE as in TOML"),
        (["slow=1"], "unknown key 'slow'"),
        (["fault_reset=-1"], "greater than or equal to 0"),
        (['refuse_read=["60C2.1"]'], "refuse_read.*pattern"),
        (['refuse_read=["XYZW"]'], "refuse_read"),
    ],
)
def test_settings_that_are_not_valid_are_explained(settings: list[str], reason: str) -> None:
    with pytest.raises(BadInput, match=reason):
        habits_from(settings, Habits())
