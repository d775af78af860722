"""Exports next to the recordings: by `ident export`, under a new name, with the document about what is lost."""

import json
from pathlib import Path
from typing import Any, cast

import pytest

from ident import plugins
from ident.workbench import controller_export
from ident.workbench.controller_export import ENDINGS, ControllerExport, targets_of
from ident.workbench.folder import Folder
from ident.workbench.topics import Changes
from recordings.errors import BadInput

MODEL, OTHER = cast(Any, object()), cast(Any, object())


@pytest.fixture
def commands(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """Commands of `ident` that were run: each writes the document of its export."""
    run: list[tuple[str, ...]] = []

    def run_ident(root: Path, *words: str) -> str | None:
        run.append(words)
        if "refused.fmu" in words:
            return "error: no compiler"
        out = root / words[words.index("-o") + 1]
        document = out / "carried.json" if words[3] == "c" else out.with_suffix(".carried.json")
        document.parent.mkdir(exist_ok=True)
        document.write_text(json.dumps({"target": words[3]}))
        return None

    monkeypatch.setattr(controller_export, "run_ident", run_ident)
    return run


def test_every_target_has_an_ending() -> None:
    assert set(ENDINGS) == set(plugins.names("ident.export.targets"))
    assert set(targets_of("delta")) == set(ENDINGS)
    assert "mjcf" not in targets_of("axes")


def test_export_belongs_to_its_model(tmp_path: Path, commands: list[tuple[str, ...]]) -> None:
    export = ControllerExport(Folder.at(tmp_path), Changes())
    for target in ENDINGS:
        name = export.free_name("a.model.json", target)
        assert name.startswith("a")
        assert export.export(MODEL, "a.model.json", target, name, None) is None
        files = export.of(MODEL)
        assert files is not None
        assert files.document == {"target": target}
        assert (files.out, files.model_name) == (name, "a.model.json")
        assert files.command == ("ident", *commands[-1])
    assert export.of(OTHER) is None
    assert not export.running
    assert export.export(MODEL, "a.model.json", "csv", "b.csv", "fig5b") is None
    assert commands[-1][-2:] == ("--traj", "fig5b")


def test_refused_export_leaves_the_last_one(tmp_path: Path, commands: list[tuple[str, ...]]) -> None:
    export = ControllerExport(Folder.at(tmp_path), Changes())
    assert export.export(MODEL, "a.json", "fmu", "refused.fmu", None) == "error: no compiler"
    assert export.of(MODEL) is None
    assert not export.running
    (tmp_path / "a_c").mkdir()
    assert export.free_name("a.json", "c") == "a-2_c"
    for name in ("a_c", "../a_c", ""):
        with pytest.raises(BadInput):
            export.export(MODEL, "a.json", "c", name, None)
    with pytest.raises(BadInput, match=r"ending in \.xml"):
        export.export(MODEL, "a.json", "mjcf", "robot.fmu", None)
    assert len(commands) == 1
