"""The table at the end of `.ci/run`, and the list of unsteady tests."""

import tomllib
from pathlib import Path

from tests.machinery.budget import read_steps, table
from tests.machinery.hand_over import Finished


def test_table_has_each_step_with_its_tests_and_the_draw(tmp_path: Path) -> None:
    (tmp_path / "steps.tsv").write_text("demo\t60.5\t80.0\t9.5\nslow tests\t180\t200\t20\n")
    runs = [Finished("slow tests", 20, 1, 3, "1/5 abc"), Finished("slow tests", 4, 0, 0, "1/1 -")]
    head, demo, slow, total, share = table(read_steps(tmp_path), runs)
    assert head.split() == ["step", "wall", "s", "CPU", "s", "tests", "skipped", "of", "all"]
    assert demo.split() == ["demo", "60", "90", "25%"]
    assert slow.split() == ["slow", "tests", "180", "220", "25", "3", "75%"]
    assert total.split() == ["in", "all", "240", "310", "25", "3", "100%"]
    assert share.endswith("make test-slow SHARE=1/5 DRAW=abc")


def test_few_tests_are_known_as_unsteady() -> None:
    assert len(tomllib.loads(Path(__file__).with_name("unsteady.toml").read_text())) < 4
