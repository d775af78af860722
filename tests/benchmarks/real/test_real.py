"""Benchmark of real machines: manifests, judgements, and the data sets where they are."""

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.real import data_set, diagnosing, tables
from benchmarks.real.data_set import Claim
from benchmarks.real.diagnosing import DiagnosedSet
from recordings.errors import BadInput
from recordings.recording import Floats

SHARED = Path(os.environ.get("REAL_DATA", Path(__file__).parents[3].parent / "shared" / "data"))
RIPPLING = ("kinova_gen3_joint_1", "kinova_gen3_joint_4", "kinova_gen3_joint_7")
"""Harmonic drives whose ripple has to be found."""
MANIFESTS = {manifest.name: manifest for manifest in data_set.manifests()}


def _document(*findings: dict[str, Any], **parameters: float) -> dict[str, Any]:
    entries = {name.replace("__", "."): {"value": value} for name, value in parameters.items()}
    step = {"held_out_rms": [1.0], "parameters": entries}
    return {"findings": list(findings), "steps": [step, step], "verdict": "adequate", "effort_units": ["N m"]}


def _finding(effect: str, *others: str) -> dict[str, Any]:
    return {"effect": effect, "confusable_with": list(others)}


@pytest.mark.parametrize(
    ("claim", "document", "judgement"),
    [
        ({"effect": "stribeck"}, _document(_finding("stribeck")), "right"),
        ({"effect": "stribeck"}, _document(_finding("torque_offset", "stribeck")), "or"),
        ({"effect": "stribeck"}, _document(), "missed"),
        ({"effect": "stribeck", "present": False}, _document(_finding("stribeck")), "wrong"),
        ({"effect": "stribeck", "present": False}, _document(), "right"),
        ({"effect": "cogging", "order": 72}, _document(_finding("cogging"), cogging__N=71.9), "right"),
        ({"effect": "cogging", "order": 72}, _document(_finding("cogging"), cogging__N=36.0), "missed"),
    ],
)
def test_claim_is_judged_by_the_findings(claim: dict[str, Any], document: dict[str, Any], judgement: str) -> None:
    manifest = MANIFESTS["cogging_bldc"].model_copy(update={"claims": (Claim(known_from="test", **claim),)})
    assert DiagnosedSet(manifest, document).claims[0][1] == judgement


def test_findings_that_nobody_knows_about_are_unknown() -> None:
    manifest = MANIFESTS["cogging_bldc"].model_copy(update={"claims": ()})
    outcome = DiagnosedSet(manifest, _document(_finding("stribeck")))
    assert outcome.claims == [("stribeck (found)", "unknown")]
    assert list(tables.lines([outcome]))[-1] == "claims: 1 unknown"


def test_missing_data_are_said_to_be_missing(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="does not exist"):
        diagnosing.diagnose(MANIFESTS["friction_damper"], tmp_path, tmp_path)
    line = list(tables.lines([DiagnosedSet(MANIFESTS["friction_damper"], None, "nothing there")]))[1]
    assert line == "  not read: nothing there"


def test_every_fourth_quarter_of_a_second_is_held_out(tmp_path: Path) -> None:
    time = np.arange(0, 8, 0.002)
    angle, torque = np.sin(3 * time), 0.4 * np.cos(3 * time) + np.sign(np.cos(3 * time))
    table = np.stack([time, angle, torque], axis=1)
    header = "time [s],position [rad],motor current [A]"
    (tmp_path / "kinova_gen3").mkdir()
    np.savetxt(tmp_path / "kinova_gen3/joint_7.csv", table, "%.6f", ",", header=header, comments="")
    outcome = diagnosing.diagnose(MANIFESTS["kinova_gen3_joint_7"], tmp_path, tmp_path)
    assert outcome.document is not None
    assert "another recording" in outcome.document["held_out"]


def _held_out_square(model: Any) -> Floats:
    """(dof,) mean square of the held-out residual [(N m)^2]."""
    residuals = [np.where(rows, x, np.nan) for rows, x in zip(model.split.test, model.judged_residuals, strict=True)]
    square: Floats = np.nanmean(np.concatenate(residuals) ** 2, axis=0)
    return square


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(MANIFESTS))
def test_nothing_false_is_said_about_real_machines_and_harmonic_drives_ripple(name: str, tmp_path: Path) -> None:
    if not SHARED.is_dir():
        pytest.skip(f"no data sets in {SHARED}")
    outcome = diagnosing.diagnose(MANIFESTS[name], SHARED, tmp_path)
    assert "wrong" not in [judgement for _, judgement in outcome.claims]
    for finding in outcome.diagnosis.selection.findings:
        floor, joints = finding.after.noise_floor.certain**2, list(finding.term.joints)
        before, after = (_held_out_square(model) for model in (finding.before, finding.after))
        if finding.term.effect.corrects_motion or finding.term.effect.whole_robot:
            joints = [int(np.argmax((before - after) / (before - floor)))]
        assert (before - after >= 0.1 * (before - floor))[joints].all(), (finding.term.name, joints)
    for line in outcome.diagnosis.ripple.lines:
        assert line.evidence.after**2 <= 0.9 * line.evidence.before**2, line
    frequencies = sorted(each.frequency for each in outcome.diagnosis.ripple.vibrations)
    assert (np.diff(frequencies) > 0.01).all(), "each is named once"
    if name in RIPPLING:
        ripple = [judgement for text, judgement in outcome.claims if text.startswith("cogging of")]
        assert ripple
        assert set(ripple) <= {"right", "or"}
    if name == "kinova_gen3_joint_7":
        assert outcome.document is not None
        assert outcome.document["steps"][-1]["held_out_rms"][0] <= 0.18
        assert outcome.document["steps"][0]["held_out_rms"][0] > 0.8
