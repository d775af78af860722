"""Names of files that are free."""

from pathlib import Path

import pytest

from recordings.files import free_name


@pytest.mark.parametrize(
    ("name", "ending", "numbered"),
    [
        ("a.model.json", None, "a-2.model.json"),
        ("a.better.model.json", None, "a.better-2.model.json"),
        ("a.diagnose.html", None, "a.diagnose-2.html"),
        ("learned.py", None, "learned-2.py"),
        ("plots", None, "plots-2"),
        ("better_c", "_c", "better-2_c"),
        ("a.feedforward.csv", ".feedforward.csv", "a-2.feedforward.csv"),
    ],
)
def test_a_name_that_is_taken_gets_a_number(tmp_path: Path, name: str, ending: str | None, numbered: str) -> None:
    taken = tmp_path / name
    assert free_name(taken, ending) == taken
    taken.touch()
    assert free_name(taken, ending) == tmp_path / numbered
    (tmp_path / numbered).symlink_to("nothing")
    assert free_name(taken, ending) == tmp_path / numbered.replace("2", "3")
