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
TRAIN = SimpleNamespace(recordings=[SimpleNamespace(name="a.mcap")])
MODEL, OTHER = (cast(Any, SimpleNamespace(train=TRAIN, number=number)) for number in range(2))


@pytest.fixture
def export(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModelExport:
    """Return an export whose models are empty files; `ident` writes the document of an export, and nothing else."""

    def run_ident(root: Path, command: str, *words: str) -> None:
        if "refused.fmu" in words:
            raise BadInput("error: no compiler")
        if command == "export":
            (root / words[-1]).mkdir()
            (root / words[-1] / "carried.json").write_text(json.dumps({"command": [command, *words]}))

    monkeypatch.setattr(model_file, "save", lambda model, path: path.touch())
    monkeypatch.setattr(model_export, "run_ident", run_ident)
    return ModelExport(Folder.at(tmp_path), Changes())


def test_each_model_is_saved_once_under_a_name_of_its_own(export: ModelExport) -> None:
    assert export.saved_name(MODEL) is export.last_saved is None
    for model, name in ((MODEL, "a.model.json"), (OTHER, "a-2.model.json")):
        assert [export.ensure_saved(model) for _ in range(2)] == [name, name]
        assert export.saved_name(model) == export.last_saved == name
    with pytest.raises(BadInput, match="not overwritten"):
        export.save(MODEL, "a-2.model.json")


def test_report_saves_the_model_first_and_no_other_file_is_served(export: ModelExport, tmp_path: Path) -> None:
    export.create_report(MODEL, STEPS)
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
    with pytest.raises(BadInput, match="a file in"):  # what the user deleted meanwhile is named
        export.create_report(MODEL, STEPS)


def test_refused_export_leaves_the_last_one(export: ModelExport) -> None:
    export.export(MODEL, "c", "a_c", None)
    files = export.export_of(MODEL)
    assert files is not None
    assert files.document == {"command": ["export", "a.model.json", "--to", "c", "-o", "a_c"]}
    assert export.free_name("a.json", "c") == "a-2_c"
    refused = {"fmu": ("refused.fmu",), "c": ("a_c", "../a_c", ""), "mjcf": ("robot.fmu",)}
    for target, name in ((target, name) for target, names in refused.items() for name in names):
        with pytest.raises(BadInput):
            export.export(MODEL, target, name, None)
        assert not export.exporting
    assert export.export_of(MODEL) is files
    assert export.export_of(OTHER) is None
