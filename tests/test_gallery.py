"""The gallery: each program of the documentation is short, is shown, and finds what the page says that it finds."""

from pathlib import Path

import pytest

from docs.gallery import EXAMPLES, run
from tests.documents import ROOT

FOUND = {
    "csv_to_effect": ["cogging on joints (1, 2, 3)"],
    "estimators": ["pso  0.98", "ls   0.98", "svd  0.8"],
    "own_effect": ["tight_spot on joints 1", "the angle: 0.35"],
    "payload": ["calibrated: m_p = 2."],
    "batch_with_dask": ["night 0: 0.19", "night 9: 0.28"],
    "controller_loop": ["with the model's torque: following error 0."],
    "arm_from_urdf": ["c_v1    0.", "c_c1    1."],
}
"""What each example prints, among other things."""


def test_every_short_program_is_shown() -> None:
    page = (ROOT / "docs" / "tutorial" / "gallery.md").read_text(encoding="utf-8")
    assert all(f"<!-- example {name} -->" in page for name in FOUND)
    assert all(len((EXAMPLES / f"{name}.py").read_text(encoding="utf-8").splitlines()) < 40 for name in FOUND)


@pytest.mark.slow
@pytest.mark.parametrize("name", FOUND)
def test_example_finds_what_it_shows(name: str, tmp_path: Path) -> None:
    printed = run(name, tmp_path / name)
    assert all(words in printed for words in FOUND[name]), printed
