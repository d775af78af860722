"""Sealed truth beside the current model."""

from pathlib import Path

import pytest

from ident.workbench.reveal import is_sealed, reveal, sentences
from recordings.errors import BadInput


def test_sentences_on_what_was_hidden_and_found() -> None:
    hidden = [
        {"name": "stribeck", "joints": [2], "verdict": "found"},
        {"name": "base_tilt", "joints": [], "verdict": "not found"},
    ]
    assert sentences({"hidden": hidden, "not_hidden": ["backlash"]}) == [
        "Hidden: stribeck on joint 2: found.",
        "Hidden: base_tilt: not found.",
        "Found, but not hidden: backlash.",
    ]
    assert sentences({"hidden": [{"name": "stribeck", "joints": [1]}]}) == ["Hidden: stribeck on joint 1."]
    assert sentences({"hidden": []}) == ["Hidden: nothing."]


def test_only_recordings_with_a_seal_can_be_revealed(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").touch()
    assert not is_sealed(tmp_path, "a.mcap")
    assert not is_sealed(tmp_path, None)
    with pytest.raises(BadInput, match="seal"):
        reveal(tmp_path, "a.mcap", None)
    (tmp_path / "a.sealed.json").touch()
    assert is_sealed(tmp_path, "a.mcap")
