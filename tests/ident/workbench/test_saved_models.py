"""Models next to the recordings: nothing is overwritten, and each file belongs to its model."""

from pathlib import Path

import pytest

from ident.identification import model_file
from ident.workbench.folder import Folder
from ident.workbench.state.saved_models import SavedModels
from ident.workbench.topics import Changes
from recordings.errors import BadInput

KEPT = Path("tests/ident/kept_models").resolve()
MODEL, OTHER = (model_file.load(KEPT / f"{name}.model.json") for name in ("lad", "rls"))
STEM = MODEL.train.recordings[0].name.removesuffix(".mcap")


@pytest.fixture
def saved(tmp_path: Path) -> SavedModels:
    return SavedModels(Folder.at(tmp_path), Changes())


def test_each_model_is_saved_once_under_a_name_of_its_own(saved: SavedModels, tmp_path: Path) -> None:
    (tmp_path / "damaged.json").write_text("{")
    assert saved.name_of(MODEL) is saved.last is None
    for model, name in ((MODEL, f"{STEM}.model.json"), (OTHER, f"{STEM}-2.model.json")):
        assert [saved.ensure_saved(model) for _ in range(2)] == [name, name]
        assert saved.name_of(model) == saved.last == name
    with pytest.raises(BadInput, match="not overwritten"):
        saved.save(MODEL, f"{STEM}-2.model.json")
    saved.add_report(f"{STEM}.model.json", "a.report.html")
    assert (saved.report_on(MODEL), saved.report_on(OTHER)) == ("a.report.html", None)


def test_another_workbench_knows_what_was_saved(saved: SavedModels, tmp_path: Path) -> None:
    saved.save(MODEL, "mine.json")
    again = SavedModels(Folder.at(tmp_path), Changes())
    assert (again.name_of(MODEL), again.name_of(OTHER)) == ("mine.json", None)
    (tmp_path / "mine.json").unlink()
    assert again.ensure_saved(MODEL) == f"{STEM}.model.json"
