"""The document of a diagnosis: verdict, entries above the low-pass, and what the console shows of it."""

import io
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.diagnosis.document.conclusion import conclusion
from ident.diagnosis.document.document import (
    Document,
    FindingEntry,
    ParameterValue,
    Remaining,
    StepEntry,
    Verdict,
    labels,
)
from ident.diagnosis.document.findings import above_low_pass, with_ripple
from ident.diagnosis.document.verdict import step_entry, to_document
from ident.diagnosis.judge.judge import Evidence
from ident.diagnosis.ripple.ripple import Ripple
from ident.dynamics.effects.base import INFINITE_TIME
from ident.dynamics.effects.library import library
from ident.output.console import diagnosis
from recordings.rig import Axis
from tests.ident import building
from tests.ident.diagnosis.ripple.test_ripple import found

SAMPLE = Path("recordings/samples/fig5a.mcap")


def test_forced_effect_that_explains_nothing_is_not_missing() -> None:
    """The sample has no such effect."""
    document = to_document(
        diagnose([SAMPLE], [SAMPLE.with_name("fig5b.mcap")], library(), DiagnosisOptions(only=("thermal_drift",)))
    )
    (finding,) = (finding for finding in document.findings if finding.effect == "thermal_drift")
    assert finding.status == "not-supported"
    assert document.sentence.startswith("thermal_drift is not confirmed. Held-out data get no better by it, and ")
    assert " t = " not in document.sentence + finding.why, "a figure that did not decide"
    assert document.verdict != "missing-effect"
    for step in document.steps:
        assert step.train_rms_all == pytest.approx(step.train_rms, rel=0.2)


def sentence_of(
    effects: Sequence[str], torque: building.Torque, axes: Sequence[Axis] = (Axis(),), **options: Any
) -> str:
    """What is said first of a bench with an additional `torque`, with these `effects` in the library."""
    rig = building.bench(len(axes)).model_copy(update={"axes": tuple(axes)})
    train, held_out = (
        replace(building.record(len(axes), noise=0.05, extra=torque, shape=shape, name=f"{shape}"), rig=rig)
        for shape in (0, 1)
    )
    chosen = {name: library()[name] for name in effects}
    return to_document(diagnose([train], [held_out], chosen, DiagnosisOptions(**options))).sentence


def test_first_sentences_say_what_how_large_and_what_it_takes() -> None:
    text = sentence_of(["quadratic_friction"], building.drag)
    what, effect, end = text.split(". ")[0], text.rpartition(" (")[2].partition(").")[0], text.partition("). ")[2]
    assert what.startswith("Beyond viscous friction, drag grows with the square of the joint's speed (")
    assert effect == "quadratic_friction: 0.3 N m s^2/rad^2", "a robot of one joint needs no number"
    assert re.match(
        r"With it the held-out error falls from 0\.\d+ to 0\.0\d+ N m, and no structured residual is left", end
    )


def test_first_sentences_name_joints_and_units_of_each_effect() -> None:
    text = sentence_of(
        ["quadratic_friction", "joint_spring"],
        lambda motion: building.drag(motion) * [1, 1, 1, 0] + motion.position * [0, 0, 0, 1],
        axes=(Axis(), Axis(), Axis(), Axis(type="prismatic")),
    )
    assert "(quadratic_friction on joints 1 to 3: 0.3 N m s^2/rad^2)." in text
    assert "(joint_spring on joint 4: 1 N/m)." in text
    assert re.search(r" With them the held-out error of joint \d falls from ", text)


def test_first_sentences_do_not_say_what_the_data_cannot_bear() -> None:
    short = sentence_of(["quadratic_friction"], building.drag, cutoff=2.0)
    assert short.endswith("but these recordings are too short to tell whether more is missing.")
    unknown = sentence_of(["joint_spring"], building.drag)
    assert unknown.startswith("A structured residual is left that no effect of the library explains: ")
    refused = sentence_of(["joint_spring"], building.drag, only=("joint_spring",))
    assert refused.startswith("joint_spring is not confirmed. ")
    assert "With what was requested, a structured residual is left above the noise floor" in refused


def concluded(
    error: float,
    torque: float = 5.0,
    structured: bool = False,
    found: bool = False,
    taken: float = 0.0,
    rows: float = 1000.0,
    **fields: Any,
) -> Verdict:
    """The verdict on one joint with a noise floor of 0.1 N m, of which a correct model leaves 0.12 N m at most."""
    floor = SimpleNamespace(rms=np.array([0.1]), limit=np.array([0.12]))
    model = SimpleNamespace(
        judged_residuals=(np.array([[error]]),),
        noise_floor=floor,
        names=set(),
        split=SimpleNamespace(independent_rows=rows, other_motion=False),
        solution=SimpleNamespace(x=np.zeros(3)),
        improvement_over=lambda first: SimpleNamespace(share=taken),
    )
    recording = building.record()
    structure = building.structure(recording, "stribeck")
    diagnosis: Any = SimpleNamespace(
        model=model,
        split=SimpleNamespace(
            scored=(np.array([[True]]),),
            torque_rms=np.array([torque]),
            recordings=[SimpleNamespace(recording=recording)],
        ),
        selection=SimpleNamespace(steps=[SimpleNamespace(model=model)], likely=()),
        ripple=SimpleNamespace(lines=(), whole=model, structure=structure, x=building.start(structure)),
        unexplained=SimpleNamespace(significant=structured, sentence=""),
        library=library(),
        **{"forced": False, "data_problems": (), **fields},
    )
    missing: Any = [SimpleNamespace(effect="stribeck", confusable_with=(), sentence="It rubs.")] * found
    return conclusion(diagnosis, missing, (np.array([2 * error]), np.array([error])))[0]


@pytest.mark.parametrize(
    ("left", "verdict"),
    [
        ({"error": 0.1}, "adequate"),
        ({"error": 0.1, "torque": 1.0}, "undetermined"),  # 3 % of the torque would not exceed the limit
        ({"error": 0.1, "rows": 50.0}, "undetermined"),  # too few for three parameters
        ({"error": 0.1, "found": True, "taken": 0.9}, "missing-effect"),
        ({"error": 0.1, "found": True, "taken": 0.09}, "missing-effect"),
        ({"error": 1.0, "found": True, "taken": 0.5}, "missing-effect"),
        ({"error": 1.0, "found": True, "taken": 0.09}, "unknown-structure"),  # negligible beside a large remainder
        ({"error": 1.0}, "undetermined"),
        ({"error": 1.0, "structured": True}, "unknown-structure"),
        ({"error": 1.0, "structured": True, "found": True, "taken": 0.9}, "unknown-structure"),
    ],
)
def test_first_rule_that_applies_decides(left: dict[str, Any], verdict: Verdict) -> None:
    assert concluded(**left) == verdict


@pytest.fixture(scope="module")
def ripple() -> Ripple:
    return found()


def test_step_adds_all_lines_with_parameters_and_intervals(ripple: Ripple) -> None:
    last, step = (step_entry("cogging", ripple.model, ripple, with_lines=lines) for lines in (False, True))
    assert step.effects == ("cogging",)
    assert step.parameters.keys() - last.parameters.keys() == {"cogging.a2", "cogging.b2", "cogging.N"}
    assert {name: step.parameters[name] for name in last.parameters} == last.parameters
    low, high = step.parameters["cogging.N"].ci95 or (0.0, 0.0)
    assert low < 160.0 < high
    assert step.held_out_rms[1] < last.held_out_rms[1]
    assert step.held_out_rms_all[1] < last.held_out_rms_all[1]


def test_ripple_is_one_finding_with_joint_order_and_doubt(ripple: Ripple) -> None:
    (finding,) = with_ripple([], ripple)
    assert (finding.effect, finding.joints, finding.confusable_with) == ("cogging", (2,), ())
    assert "joint 2: 159.99" in finding.why
    evidence = finding.evidence
    assert evidence.gain > 0.3
    assert evidence.band_hz == ripple.lines[0].evidence.band
    (same, before), (unchanged, after) = evidence.rms_before or (), evidence.rms_after or ()
    assert same == unchanged, "the joint that does not ripple"
    assert after**2 < (1 - 0.5 * evidence.gain) * before**2
    assert f"from {before:.3g} to {after:.3g}" in finding.why
    uncertain = replace(ripple, lines=(replace(ripple.lines[0], same_frequency=41.0),))
    (doubted,) = with_ripple([], uncertain)
    assert doubted.confusable_with == ("vibration",)
    assert "a vibration of 41 Hz" in doubted.why
    below = finding.model_copy(update={"joints": (1,), "why": "Below."})
    (joined,) = with_ripple([below], ripple)
    assert joined.joints == (1, 2)
    assert joined.why.startswith("Below. Above the low-pass")


def test_unexplained_share_above_the_low_pass_is_stated(ripple: Ripple) -> None:
    entry = above_low_pass(ripple)
    assert entry is not None
    assert entry.unexplained_share == pytest.approx(tuple(ripple.unexplained_share))
    assert entry.why.startswith("Above the low-pass, up to 200 Hz")
    assert above_low_pass(replace(ripple, bands=(), lines=())) is None


STEP = StepEntry(
    added="payload_change",
    effects=(),
    train_rms=(0.1,),
    held_out_rms=(0.1,),
    train_rms_all=(0.1,),
    held_out_rms_all=(0.25,),
    parameters={
        f"payload_change.{name}": ParameterValue(
            value=value, unit="s", ci95=None, meaning=meaning, lower=None, upper=None
        )
        for name, value, meaning in (
            ("t_c", 7.25, "when it is added"),
            ("t_e", INFINITE_TIME, "when it is taken off"),
        )
    },
)
EVIDENCE = Evidence(gain=0.5, gain_ci95=(0.4, 0.6), t=9.0, t_required=3.5, power=1.0, decided_by="held-out")
FINDING = FindingEntry(
    effect="payload_change", joints=(1,), evidence=EVIDENCE, confusable_with=(),
    **dict.fromkeys(("why", "sentence", "symptom", "causes", "remedy"), ""),
)  # fmt: skip
DOCUMENT = Document(
    schema=2, verdict="missing-effect", sentence="It lacks a load.", bandwidth_hz=30.0, noise_rms=(0.1,),
    noise_ci95=((0.09, 0.11),), noise_source="repetition", torque_rms=(5.0,), explained_share=(0.99,),
    joints=("joint_1",), effort_units=("N m",), simulated=True, held_out="", findings=(FINDING,), rejected=(),
    steps=(STEP.model_copy(update={"added": None, "held_out_rms": (0.82,), "parameters": {}}), STEP),
    remaining=Remaining(structured_share=0.0, depends_on=(), why="", structured_rms=(0.0,)), next_motion=None,
)  # fmt: skip


def shown(document: Document) -> list[str]:
    output = io.StringIO()
    diagnosis.show(document, Console(file=output, width=120))
    return output.getvalue().splitlines()


def test_console_prints_never_for_infinite_instants_and_the_conclusion_last() -> None:
    lines = shown(DOCUMENT)
    text = " ".join(lines)
    assert "t_c = 7.25 s  when it is added" in text
    assert "t_e = never  when it is taken off" in text
    assert "95 % intervals" in text
    assert lines[1] == "missing-effect: It lacks a load.", "first what a person would say"
    assert lines[-2].startswith("missing-effect. Held-out error"), "the last lines are the result"
    assert lines[-1].split() == ["joint_1", "0.82", "→", "0.1", "N", "m"]


@pytest.mark.parametrize(("on_all_rows", "printed"), [(0.25, True), (0.1, False)])
def test_errors_on_all_rows_are_printed_if_they_differ(on_all_rows: float, printed: bool) -> None:
    last = STEP.model_copy(update={"held_out_rms_all": (on_all_rows,)})
    lines = shown(DOCUMENT.model_copy(update={"steps": (last,)}))
    assert ["0.1 | 0.25" in line for line in lines if "last model, on all rows" in line] == [True] * printed


def test_label_names_the_effects_added_and_removed() -> None:
    base, mandatory = (), ("rod_inertia",)
    assert labels([base, mandatory, (*mandatory, "cogging")]) == ["base model", "+ rod_inertia", "+ cogging"]
    assert labels([base, (*mandatory, "cogging")]) == ["base model", "+ rod_inertia + cogging"]
    assert labels([mandatory, (*mandatory, "backlash")]) == ["base model with rod_inertia", "+ backlash"]
    assert labels([("cogging",), ("cogging", "cogging")])[1] == "+ cogging", "another line of the spectrum"
    assert labels([("joint_spring",), ("backlash",)])[1] == "+ backlash − joint_spring"
    assert labels([mandatory, mandatory])[1] == "the same effects, refitted"


@pytest.mark.parametrize(
    ("value", "interval", "text"),
    [
        (2400.2601, (2400.0512, 2400.4731), "2400.26 (2400.05 to 2400.47) 1/turn"),
        (0.2741, (0.214, 0.33431), "0.2741 (0.214 to 0.3343) 1/turn"),
        (0.0, (0.0, 0.0), "0 1/turn"),
        (1.5, None, "1.5 1/turn"),
    ],
)
def test_parameter_in_words_shows_by_how_much_its_bounds_differ(
    value: float, interval: tuple[float, float] | None, text: str
) -> None:
    entry = ParameterValue(value=value, unit="1/turn", ci95=interval, meaning="", lower=None, upper=None)
    assert entry.in_words == text
