"""Commands that come next, with names of outputs that do not exist."""

from pathlib import Path

import pytest

from recordings.next_command import better_name, diagnosis, free_name, free_output


@pytest.mark.parametrize(
    ("name", "numbered"),
    [
        ("a.model.json", "a2.model.json"),
        ("a.better.model.json", "a.better2.model.json"),
        ("a.diagnose.html", "a.diagnose2.html"),
        ("learned.py", "learned2.py"),
        ("better_c", "better_c2"),
    ],
)
def test_a_name_that_is_taken_gets_a_number(tmp_path: Path, name: str, numbered: str) -> None:
    taken = tmp_path / name
    assert free_name(taken) == taken
    assert free_output("-o", taken) == []
    taken.touch()
    assert free_output("-o", taken) == ["-o", tmp_path / numbered]
    (tmp_path / numbered).touch()
    assert free_name(taken) == tmp_path / numbered.replace("2", "3")


def test_a_better_model_never_takes_the_name_of_another(tmp_path: Path) -> None:
    first = better_name(tmp_path / "a.model.json")
    assert first.name == "a.better.model.json"
    first.touch()
    second = better_name(first)
    assert second.name == "a.better2.model.json"
    second.touch()
    assert better_name(second).name == better_name(tmp_path / "a.json").name == "a.better3.model.json"


def test_words_of_a_diagnosis_name_outputs_only_where_they_must(tmp_path: Path) -> None:
    file, model, page = (tmp_path / f"a.{ending}" for ending in ("mcap", "model.json", "diagnose.html"))
    assert diagnosis([file], "--validate", "b.mcap") == ["ident", "diagnose", file, "--validate", "b.mcap"]
    assert diagnosis([file], model=model) == ["ident", "diagnose", file, "--apply"]
    model.touch()
    page.touch()
    better, other_page = tmp_path / "a.better.model.json", tmp_path / "a.diagnose2.html"
    expected = ["ident", "diagnose", file, "--apply", "-o", better, "--report", other_page]
    assert diagnosis([file], model=model) == expected
