"""Inertial parameters that no bodies have are told."""

import pytest

import ident

pytest.importorskip("pinocchio")

from tests.ident import arms


def said(true: str, told: str, **mistake: float) -> bool:
    assessment = ident.fit(arms.record(true, arms.without_masses(told), **mistake)).file.assessment
    assert assessment is not None
    return any(each.name == "links" and "no bodies" in each.sentence for each in assessment.warnings)


@pytest.mark.parametrize("axes", [arms.LIFTING, arms.SHOULDER])
def test_only_wrong_data_or_a_wrong_rig_file_has_links_that_are_no_bodies(axes: tuple[str, ...]) -> None:
    true = arms.urdf(axes)
    turned = arms.urdf((*axes[:-1], "0 -1 0"))
    assert not said(true, true)
    assert said(true, turned)
    assert said(true, arms.urdf(axes, length=0.2))
    assert said(true, true, weight=0.0)
