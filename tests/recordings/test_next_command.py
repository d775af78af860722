"""Commands that come next, with names of outputs that do not exist."""

from pathlib import Path

from recordings.next_command import better_name, diagnosis


def test_a_better_model_never_takes_the_name_of_another(tmp_path: Path) -> None:
    first = better_name(tmp_path / "a.model.json")
    assert first.name == "a.better.model.json"
    first.touch()
    second = better_name(first)
    assert second.name == "a.better-2.model.json"
    second.touch()
    assert better_name(second).name == better_name(tmp_path / "a.json").name == "a.better-3.model.json"


def test_words_of_a_diagnosis_name_outputs_only_where_they_must(tmp_path: Path) -> None:
    file, model = (tmp_path / f"a.{ending}" for ending in ("mcap", "model.json"))
    assert diagnosis([file], "--validate", "b.mcap") == ["ident", "diagnose", file, "--validate", "b.mcap"]
    assert diagnosis([file], model=model) == ["ident", "diagnose", file, "--apply"]
    model.touch()
    better = tmp_path / "a.better.model.json"
    assert diagnosis([file], model=model) == ["ident", "diagnose", file, "--apply", "-o", better]
