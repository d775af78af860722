"""Parts of the benchmark."""

from benchmarks.hidden_effects.parts import PARTS, cases


def test_parts_have_no_case_in_common() -> None:
    names = [{case.name for case in cases("foreign", part, "1a2b")} for part in PARTS]
    assert len(set.union(*names)) == sum(len(part) for part in names)


def test_only_the_locked_part_depends_on_the_digest() -> None:
    same = [cases("foreign", part, "1a2b") == cases("foreign", part, "3c4d") for part in PARTS]
    assert dict(zip(PARTS, same, strict=True)) == {"tuned": True, "chosen": True, "locked": False}


def test_simulated_rig_has_the_tuned_part_only() -> None:
    assert [bool(cases("simulated", part)) for part in PARTS] == [True, False, False]
