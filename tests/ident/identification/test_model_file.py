import json
from pathlib import Path
from typing import Any

import pytest

from ident.identification import model_file
from ident.identification.model_file import ModelFile
from recordings.errors import BadInput

AGREEMENT: dict[str, Any] = {
    "recordings": [{"name": "a.mcap", "sha256": "00", "simulated": True}],
    "fitted": {"nrmse": [0.9, 0.9, 0.9], "rms": [0.1, 0.1, 0.1], "r2": [0.9, 0.9, 0.9]},
    "nominal": {"nrmse": [0.8, 0.8, 0.8], "rms": [0.2, 0.2, 0.2], "r2": [0.5, 0.5, 0.5]},
}
CONTENT: dict[str, Any] = {
    "schema": 2,
    "software": "0.1.0",
    "mechanism": "delta",
    "joints": ["joint_1", "joint_2", "joint_3"],
    "geometry": {},
    "torque": {},
    "relative": True,
    "parameters": [
        {"name": "m_p", "value": 1, "unit": "kg", "lower": 0, "upper": 9, "at_bound": False, "paper_value": 1}
    ],
    "method": {"name": "pso", "settings": {"particles": 300}, "seed": 0, "objective": 1.5, "rows": 100},
    "preprocessing": {"name": "parallel", "bandwidth": 30, "rate": 125},
    "train": AGREEMENT,
    "validate": AGREEMENT,
}


def written(path: Path, **changes: Any) -> Path:
    path.write_text(json.dumps({**CONTENT, **changes}))
    return path


def test_a_saved_model_is_loaded_unchanged(tmp_path: Path) -> None:
    loaded = model_file.load(written(tmp_path / "a.json"))
    assert loaded.validate_ is not None
    model_file.save(loaded, tmp_path / "b.json")
    assert model_file.load(tmp_path / "b.json") == loaded
    model_file.save(loaded, tmp_path / "c.json")
    assert (tmp_path / "b.json").read_bytes() == (tmp_path / "c.json").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "b.json", "c.json"]


def test_validation_is_optional(tmp_path: Path) -> None:
    assert model_file.load(written(tmp_path / "a.json", validate=None)).validate_ is None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"schema": 3}, "schema 2 expected, 3 found; update"),
        ({"schema": 1}, "schema 2 expected, 1 found; fit the recordings again"),
        ({"schema": None}, "is it a model"),
        ({"mechanism": "octopod"}, "mechanism"),
        ({"parameters": [{"name": "m_p"}]}, "parameters"),
        ({"surprise": 1}, "unknown key 'surprise'"),
    ],
)
def test_an_invalid_model_is_refused(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        model_file.load(written(tmp_path / "a.json", **changes))


def test_a_recording_in_place_of_a_model_is_named_as_such(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(b"\x89MCAP0\r\n")
    with pytest.raises(BadInput, match="a file that is no text found; give the model"):
        model_file.load(path)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b"{", b"[1]", b"89"])
def test_a_file_that_is_not_a_model_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(content)
    with pytest.raises(BadInput, match=r"a\.json"):
        model_file.load(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="does not exist"):
        model_file.load(tmp_path / "none.json")


def test_a_model_contains_the_software_version_and_the_schema() -> None:
    content = {key: value for key, value in CONTENT.items() if key not in ("software", "schema")}
    signed = ModelFile.model_validate_json(json.dumps(content))
    assert signed.as_json()["schema"] == model_file.SCHEMA
    assert signed.software
