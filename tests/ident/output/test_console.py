"""What is printed: tables, sentences, and no text of a user as markup."""

import io
from typing import Any

import numpy as np
from rich.console import Console

from ident.data.recording_facts import RecordingFacts
from ident.design.designs import DesignResult
from ident.design.quality import Quality
from ident.diagnosis.visibility.check import CheckDocument, CheckedEffect, CheckedJoint
from ident.output.console import check, design

JOINT = CheckedJoint(
    joint="shoulder", position_unit="rad", effort_unit="N m", travel=1.5, highest_speed=4.0, speed_spread=0.6,
    forward_share=0.5, encoder_step=None, drive_step=None, torque_rms=10.0, torque_spread=1.0, noise_rms=0.5,
)  # fmt: skip
RECORDING = RecordingFacts(
    joints=(), file="a.mcap", simulated=True, rate_hz=500.0, jitter=0.01, duration_s=8.0, cycles=2
)


def shown(show: Any, document: Any) -> str:
    screen = io.StringIO()
    show(document, Console(file=screen, width=120))
    return screen.getvalue()


def effect(name: str, **fields: object) -> CheckedEffect:
    defaults = {"joints": (), "confusable_with": (), "smallest": None, "why": "Because.", "record": None}
    return CheckedEffect.model_validate({"effect": name, "command": None, **defaults, **fields})


def test_checked_effects_stand_in_groups_with_what_to_record() -> None:
    command = f"ident design --with joint_spring {'--recording long_name.mcap ' * 9}-o next.toml"
    effects = (
        effect("stribeck", status="visible", joints=(1, 2)),
        effect("cogging", status="visible", joints=(2,)),
        effect("joint_spring", status="not-visible", record="Record more.", command=command),
        effect("mine", status="not-visible", why="[bold]x[/] was"),
    )
    document = CheckDocument(
        schema=2, share=0.03, bandwidth_hz=30.0, recordings=(RECORDING,), joints=(JOINT, JOINT), effects=effects
    )
    text = shown(check.show, document)
    assert "SIMULATED" in text
    assert "a.mcap: 500 Hz, steps jitter by 1 %, 8 s, 2 cycles" in text
    assert "0.5 N m" in text
    assert "\n  stribeck: Because." in text, "all joints need no list"
    assert "\n  cogging (joint 2): Because." in text
    assert "would explain it as well" not in text, "no group without effects"
    assert f"    Record more.\n    {command}\n" in text, "a command is never wrapped"
    assert "[bold]x[/] was" in text, "texts of a user are no markup"


def test_shares_of_a_design_have_no_exponent() -> None:
    shares = {"stribeck": 0.0123, "base_tilt": 0.996, "[red]mine": 1.84, "cogging": 188.5}
    after = Quality(condition=1.0, std=np.array([]), discriminability=shares, usage={})
    text = shown(design.show, DesignResult("next.toml", "d", 0, 0.1, 10.0, (), after, None, None))
    for expected in ("1.2 %", "100 %", "184 %", "18,850 %", "[red]mine"):
        assert f" {expected}" in text
    assert "e+" not in text
