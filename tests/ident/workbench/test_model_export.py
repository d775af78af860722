"""What is made of a model next to the recordings: nothing is overwritten, and each file belongs to its model."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from ident.identification import model_file
from ident.workbench.folder import Folder
from ident.workbench.state import model_export
from ident.workbench.state.model_export import ModelExport
from ident.workbench.topics import Changes
from recordings.errors import BadInput

STEPS = cast(Any, SimpleNamespace(train="a.mcap", validate=None))
MODEL, OTHER = cast(Any, object()), cast(Any, object())


@pytest.fixture
def commands() -> list[tuple[str, ...]]:
    """Commands of `ident` that were run."""
    return []


@pytest.fixture
def export(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, commands: list[tuple[str, ...]]) -> ModelExport:
    """Return an export whose models are empty files; `ident` writes the document of an export, and nothing else."""

    def run_ident(root: Path, *words: str) -> str | None:
        commands.append(words)
        if "refused.fmu" in words:
            return "error: no compiler"
        if words[0] == "export":
            out = root / words[words.index("-o") + 1]
            document = out / "carried.json" if words[3] == "c" else out.with_suffix(".carried.json")
            document.parent.mkdir(exist_ok=True)
            document.write_text(json.dumps({"target": words[3]}))
        return None

    monkeypatch.setattr(model_file, "save", lambda model, path: path.touch())
    monkeypatch.setattr(model_export, "run_ident", run_ident)
    return ModelExport(Folder.at(tmp_path), Changes())


def test_each_model_is_saved_once_under_a_name_of_its_own(export: ModelExport) -> None:
    assert export.saved_name(MODEL) is export.last_saved is None
    for model, name in ((MODEL, "a.model.json"), (OTHER, "a-2.model.json")):
        assert [export.ensure_saved(model, STEPS) for _ in range(2)] == [name, name]
        assert export.saved_name(model) == export.last_saved == name
    with pytest.raises(BadInput, match="not overwritten"):
        export.save(MODEL, "a-2.model.json")


def test_report_saves_the_model_first_and_no_other_file_is_served(export: ModelExport, tmp_path: Path) -> None:
    assert export.create_report(MODEL, STEPS) is None
    assert not export.creating_report
    assert (tmp_path / "a.model.json").exists()
    assert export.report_name(MODEL) == "a.report.html"
    for name in ("a.report.html", "other.report.html"):
        (tmp_path / name).touch()
    assert export.report("a.report.html") == tmp_path / "a.report.html"
    for name in ("other.report.html", "../a.report.html", "a.model.json", ""):
        with pytest.raises(BadInput, match="a report of this session"):
            export.report(name)
    (tmp_path / "a.model.json").unlink()
    assert "a file in" in (export.create_report(MODEL, STEPS) or ""), "what the user deleted meanwhile is named"


def test_refused_export_leaves_the_last_one(
    export: ModelExport, tmp_path: Path, commands: list[tuple[str, ...]]
) -> None:
    assert export.export(MODEL, "a.json", "fmu", "refused.fmu", None) == "error: no compiler"
    assert export.export_of(MODEL) is None
    assert not export.exporting
    (tmp_path / "a_c").mkdir()
    assert export.free_name("a.json", "c") == "a-2_c"
    for target, name in (("c", "a_c"), ("c", "../a_c"), ("c", ""), ("mjcf", "robot.fmu")):
        with pytest.raises(BadInput):
            export.export(MODEL, "a.json", target, name, None)
    assert len(commands) == 1
