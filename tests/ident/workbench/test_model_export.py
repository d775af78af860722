"""Models and reports next to the recordings: nothing is overwritten, and only reports of the session are served."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from ident.identification import model_file
from ident.workbench import model_export
from ident.workbench.folder import Folder
from ident.workbench.model_export import ModelExport
from ident.workbench.topics import Changes
from recordings.errors import BadInput

STEPS = cast(Any, SimpleNamespace(train="a.mcap", validate=None))


@pytest.fixture
def export(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModelExport:
    """Return an export whose models are empty files, and whose reports take no time."""
    monkeypatch.setattr(model_file, "save", lambda model, path: path.touch())
    monkeypatch.setattr(model_export, "run_ident", lambda root, *words: None)
    return ModelExport(Folder.at(tmp_path), Changes())


def test_each_model_gets_a_name_of_its_own(export: ModelExport) -> None:
    first, second = cast(Any, object()), cast(Any, object())
    assert export.saved_name(first) is export.last_saved is None
    for model, name in ((first, "a.model.json"), (second, "a-2.model.json")):
        assert export.free_name(STEPS) == name
        export.save(model, name)
        assert export.saved_name(model) == export.last_saved == name
    with pytest.raises(BadInput, match="not overwritten"):
        export.save(first, "a-2.model.json")


def test_model_is_saved_once(export: ModelExport) -> None:
    model = cast(Any, object())
    assert [export.ensure_saved(model, STEPS) for _ in range(2)] == ["a.model.json", "a.model.json"]
    assert export.ensure_saved(cast(Any, object()), STEPS) == "a-2.model.json"


def test_report_saves_the_model_first(export: ModelExport, tmp_path: Path) -> None:
    model = cast(Any, object())
    assert export.create_report(model, STEPS, "a.model.json") is None
    assert not export.creating_report
    assert (tmp_path / "a.model.json").exists()
    assert export.report_name(model) == "a.report.html"
    (tmp_path / "a.report.html").touch()
    assert export.report("a.report.html") == tmp_path / "a.report.html"
    assert "not overwritten" in (export.create_report(cast(Any, object()), STEPS, "a.model.json") or "")


@pytest.mark.parametrize("name", ["other.report.html", "../a.report.html", "a.model.json", ""])
def test_no_other_file_is_served(name: str, export: ModelExport, tmp_path: Path) -> None:
    (tmp_path / "other.report.html").touch()
    with pytest.raises(BadInput, match="a report of this session"):
        export.report(name)
