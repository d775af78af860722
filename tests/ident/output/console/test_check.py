"""What `ident check` prints."""

import io

from rich.console import Console

from ident.data.recording_facts import RecordingFacts
from ident.diagnosis.visibility.visibility import SmallestSize
from ident.diagnosis.visibility.visibility_document import (
    CheckDocument,
    CheckedEffect,
    CheckedJoint,
)
from ident.output.console import check

JOINT = CheckedJoint(
    joint="shoulder",
    position_unit="rad",
    effort_unit="N m",
    travel=1.5,
    highest_speed=4.0,
    speed_spread=0.6,
    forward_share=0.5,
    encoder_step=None,
    drive_step=None,
    torque_rms=10.0,
    torque_spread=1.0,
    noise_rms=0.5,
)
RECORDING = RecordingFacts(
    joints=(), file="a.mcap", simulated=True, rate_hz=500.0, jitter=0.01, duration_s=8.0, cycles=2
)


def effect(name: str, **fields: object) -> CheckedEffect:
    defaults = {"joints": (), "confusable_with": (), "smallest": None, "why": "Because.", "record": None}
    return CheckedEffect.model_validate({"effect": name, "command": None, **defaults, **fields})


def shown(*effects: CheckedEffect) -> str:
    document = CheckDocument(
        schema=2, share=0.03, bandwidth_hz=30.0, recordings=(RECORDING,), joints=(JOINT, JOINT), effects=effects
    )
    screen = io.StringIO()
    check.show(document, Console(file=screen, width=100))
    return screen.getvalue()


def test_effects_stand_in_groups_with_what_to_record() -> None:
    smallest = SmallestSize(share=0.01, parameter="a", value=0.1, unit="N m")
    command = f"ident design --with joint_spring {'--recording long_name.mcap ' * 9}-o next.toml"
    text = shown(
        effect("stribeck", status="visible", joints=(1, 2), smallest=smallest),
        effect("cogging", status="visible", joints=(2,), smallest=smallest),
        effect("joint_spring", status="not-visible", record="Record more.", command=command),
    )
    assert "SIMULATED" in text
    assert "a.mcap: 500 Hz, steps jitter by 1 %, 8 s, 2 cycles" in text
    assert "0.5 N m" in text
    assert "\n  stribeck: Because." in text, "all joints need no list"
    assert "\n  cogging (joint 2): Because." in text
    assert "would explain it as well" not in text, "no group without effects"
    assert f"    Record more.\n    {command}\n" in text, "a command is never wrapped"


def test_texts_of_a_user_are_no_markup() -> None:
    assert "[bold]x[/] was" in shown(effect("mine", status="not-visible", why="[bold]x[/] was"))
