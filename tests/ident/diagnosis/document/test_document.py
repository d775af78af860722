"""The document of a diagnosis on the console and in the report."""

import io

from rich.console import Console

from ident.diagnosis.document.document import (
    Document,
    FindingEntry,
    ParameterValue,
    Remaining,
    StepEntry,
    labels,
)
from ident.diagnosis.judge.evidence import Evidence
from ident.dynamics.effects.base import INFINITE_TIME
from ident.output.console import diagnosis
from ident.output.tables.parameters import with_meanings

ADDED = ParameterValue(value=7.25, unit="s", ci95=None, meaning="when it is added", lower=0.0, upper=INFINITE_TIME)
REMOVED = ParameterValue(
    value=INFINITE_TIME, unit="s", ci95=None, meaning="when it is taken off again", lower=None, upper=INFINITE_TIME
)
EVIDENCE = Evidence(gain=0.5, gain_ci95=(0.4, 0.6), t=9.0, t_required=3.5, power=1.0, decided_by="held-out")
PARAMETERS = {"payload_change.t_c": ADDED, "payload_change.t_e": REMOVED}


def test_infinite_instant_is_printed_as_never_and_the_conclusion_last() -> None:
    finding = FindingEntry(
        effect="payload_change", joints=(1,), confusable_with=(), evidence=EVIDENCE, why="", sentence="",
        symptom="", causes="", remedy="",
    )  # fmt: skip
    step = StepEntry(added="payload_change", effects=(), train_rms=(0.1,), held_out_rms=(0.1,), parameters=PARAMETERS)
    base = step.model_copy(update={"added": None, "held_out_rms": (0.82,), "parameters": {}})
    document = Document(
        schema=2, verdict="missing-effect", sentence="The base model lacks payload_change.", bandwidth_hz=30.0,
        noise_rms=(0.1,), noise_ci95=((0.09, 0.11),), noise_source="repetition", torque_rms=(5.0,),
        explained_share=(0.99,),
        joints=("joint_1",), effort_units=("N m",), simulated=True, held_out="", steps=(base, step),
        findings=(finding,), rejected=(),
        remaining=Remaining(structured_share=0.0, depends_on=(), why="", structured_rms=(0.0,)), next_motion=None,
    )  # fmt: skip
    output = io.StringIO()
    diagnosis.show(document, Console(file=output, width=120))
    assert "payload_change.t_c = 7.25 s  when it is added" in output.getvalue()
    assert "95 % intervals" in output.getvalue()
    assert "payload_change.t_e = never  when it is taken off again" in output.getvalue()
    conclusion = output.getvalue().splitlines()[-3:]
    assert conclusion[0] == "missing-effect: The base model lacks payload_change.", "the last lines are the result"
    assert conclusion[-1].split() == ["joint_1", "0.82", "→", "0.1", "N", "m"]
    assert [row[1] for row in with_meanings(PARAMETERS).rows] == ["7.250", "never"]
    assert document.as_json()["steps"][-1]["parameters"]["payload_change.t_e"]["value"] == INFINITE_TIME


def test_errors_on_all_rows_are_printed_if_they_differ() -> None:
    step = StepEntry(
        added=None, effects=(), train_rms=(0.1,), held_out_rms=(0.1,), parameters={}, train_rms_all=(0.11,),
        held_out_rms_all=(0.25,),
    )  # fmt: skip
    document = Document(
        schema=2, verdict="undetermined", sentence="No missing effect was found.", bandwidth_hz=30.0,
        noise_rms=(0.1,), noise_ci95=((0.08, 0.12),), noise_source="spectrum", torque_rms=(5.0,),
        explained_share=(0.99,),
        joints=("joint_1",), effort_units=("N m",), simulated=False, held_out="", steps=(step,), findings=(),
        rejected=(),
        remaining=Remaining(structured_share=0.0, depends_on=(), why="", structured_rms=(0.0,)), next_motion=None,
    )  # fmt: skip
    output = io.StringIO()
    diagnosis.show(document, Console(file=output, width=120))
    assert "undetermined: No missing effect was found." in output.getvalue()
    (line,) = (line for line in output.getvalue().splitlines() if "last model, on all rows" in line)
    assert "0.11 | 0.25" in line
    like = step.model_copy(update={"held_out_rms_all": (0.11,)})
    output = io.StringIO()
    diagnosis.show(document.model_copy(update={"steps": (like,)}), Console(file=output, width=120))
    assert "on all rows" not in output.getvalue()


def test_label_names_the_effects_added_and_removed() -> None:
    base, mandatory = (), ("rod_inertia",)
    assert labels([base, mandatory, (*mandatory, "cogging")]) == ["base model", "+ rod_inertia", "+ cogging"]
    assert labels([base, (*mandatory, "cogging")]) == ["base model", "+ rod_inertia + cogging"]
    assert labels([mandatory, (*mandatory, "backlash")]) == ["base model with rod_inertia", "+ backlash"]
    assert labels([("cogging",), ("cogging", "cogging")])[1] == "+ cogging", "another line of the spectrum"
    assert labels([("joint_spring",), ("backlash",)])[1] == "+ backlash − joint_spring"
    assert labels([mandatory, mandatory])[1] == "the same effects, refitted"
