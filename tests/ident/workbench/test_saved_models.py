"""Models next to the recordings: nothing is overwritten, and each file belongs to its model."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from ident.identification import model_file
from ident.workbench.folder import Folder
from ident.workbench.state.saved_models import SavedModels
from ident.workbench.topics import Changes
from recordings.errors import BadInput

TRAIN = SimpleNamespace(recordings=[SimpleNamespace(name="a.mcap")])
MODEL, OTHER = (cast(Any, SimpleNamespace(train=TRAIN, number=number)) for number in range(2))


@pytest.fixture
def saved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SavedModels:
    """Return models that are empty files."""
    monkeypatch.setattr(model_file, "save", lambda model, path: path.touch())
    return SavedModels(Folder.at(tmp_path), Changes())


def test_each_model_is_saved_once_under_a_name_of_its_own(saved: SavedModels, tmp_path: Path) -> None:
    assert saved.name_of(MODEL) is saved.last is None
    for model, name in ((MODEL, "a.model.json"), (OTHER, "a-2.model.json")):
        assert [saved.ensure_saved(model) for _ in range(2)] == [name, name]
        assert saved.name_of(model) == saved.last == name
    with pytest.raises(BadInput, match="not overwritten"):
        saved.save(MODEL, "a-2.model.json")
    saved.add_report("a.model.json", "a.report.html")
    assert (saved.report_on(MODEL), saved.report_on(OTHER)) == ("a.report.html", None)
    (tmp_path / "a.model.json").unlink()
    with pytest.raises(BadInput, match="a file in"):  # what the user deleted meanwhile is named
        saved.ensure_saved(MODEL)
