import json
from pathlib import Path

import pytest

from drivers.simulated.seal import seal, sealed_path, unseal
from recordings.errors import BadInput

TRUTH = {"effects": [{"name": "stribeck", "joints": [1], "size": 0.03}], "seed": 7}


def test_unseal_returns_the_sealed_content(tmp_path: Path) -> None:
    path = sealed_path(tmp_path / "run.mcap")
    seal(path, TRUTH)
    assert unseal(path) == TRUTH
    assert path.name == "run.sealed.json"


def test_sealed_file_is_not_legible(tmp_path: Path) -> None:
    seal(tmp_path / "a", TRUTH)
    text = (tmp_path / "a").read_text()
    assert "stribeck" not in text
    assert json.loads(text)["note"].startswith("sealed")


def test_existing_file_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "a"
    seal(path, TRUTH)
    with pytest.raises(BadInput, match="exists already"):
        seal(path, {})
    assert unseal(path) == TRUTH


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"sealed": "???", "sha256": ""}', '{"sealed": 1, "sha256": ""}'])
def test_other_files_are_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a"
    path.write_text(text)
    with pytest.raises(BadInput, match="not a sealed file"):
        unseal(path)


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="does not exist"):
        unseal(tmp_path / "a")


def test_changed_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a"
    seal(path, TRUTH)
    wrapper = json.loads(path.read_text())
    wrapper["sealed"] = wrapper["sealed"][:-8] + "AAAAAAA="
    path.write_text(json.dumps(wrapper))
    with pytest.raises(BadInput, match="was changed"):
        unseal(path)
