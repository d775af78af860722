"""Contradictions between estimates of the same effect."""

from collections.abc import Sequence

import pytest

from ident.diagnosis.document.document import ParameterValue, StepEntry
from ident.diagnosis.document.estimate_consistency import consistency_warnings
from ident.diagnosis.split.split_data import SplitData
from recordings.recording import Recording
from tests.ident import building


def spring(stiffness: float, name: str, shape: int) -> Recording:
    return building.record(
        noise=0.05, extra=lambda motion: 0.3 + stiffness * motion.position, name=name, shape=shape, seed=shape
    )


def warnings(data: SplitData, *names: str, steps: Sequence[StepEntry] = ()) -> list[str]:
    return list(consistency_warnings(building.fitted(data, *names), steps))


@pytest.mark.parametrize(("stiffness", "contradict"), [((0.3, 4.0), True), ((1.0, 1.0), False), ((1.0, 1.2), False)])
def test_estimates_from_different_files_are_compared(stiffness: tuple[float, float], contradict: bool) -> None:
    data = building.split([spring(k, name, i) for i, (k, name) in enumerate(zip(stiffness, "ab", strict=True))])
    texts = warnings(data, "joint_spring")
    assert bool(texts) is contradict
    if contradict:
        assert "joint_spring.k1 differs between the files: 0.3" in texts[0]
        assert "from a.mcap alone, 4" in texts[0]


def test_effects_that_the_motion_hardly_distinguishes_are_known_only_together() -> None:
    recording = building.record(noise=0.05, extra=lambda motion: motion.position, size=0.1)
    (text,) = warnings(building.split([recording]), "joint_spring", "arm_com_offset")
    assert text.startswith("joint_spring.k1 and arm_com_offset.a1 are known only together")


def test_effects_that_the_motion_distinguishes_are_not_mentioned() -> None:
    recording = building.record(noise=0.05, extra=lambda motion: motion.position, size=1.5)
    assert warnings(building.split([recording]), "joint_spring", "quadratic_friction") == []


def step(added: str, value: float, half: float) -> StepEntry:
    parameter = ParameterValue(
        value=value, unit="N m/rad", ci95=(value - half, value + half), meaning="", lower=None, upper=None
    )
    return StepEntry(
        added=added,
        effects=(),
        train_rms=(),
        held_out_rms=(),
        parameters={"joint_spring.k1": parameter, "I": parameter},
    )


@pytest.mark.parametrize(
    ("after", "half", "contradict"), [(4.0, 1.0, True), (4.0, 5.0, False), (0.4, 0.01, False), (-0.3, 0.1, True)]
)
def test_estimate_that_another_effect_changes_much_is_pointed_out(
    after: float, half: float, contradict: bool
) -> None:
    data = building.split([building.record(noise=0.05)])
    texts = warnings(data, steps=[step("joint_spring", 0.283, 0.03), step("arm_com_offset", after, half)])
    assert bool(texts) is contradict
    if contradict:
        assert texts[0].startswith("joint_spring.k1 was 0.283 N m/rad before arm_com_offset was added")
