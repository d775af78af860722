import json
from pathlib import Path

import pytest

from drivers.simulated.seal import seal, unseal
from recordings.errors import BadInput

TRUTH = {"effects": [{"name": "stribeck", "joints": [1], "size": 0.03}], "seed": 7}


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"sealed": "???", "sha256": ""}', '{"sealed": 1, "sha256": ""}'])
def test_other_missing_and_changed_files_are_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a"
    with pytest.raises(BadInput, match="does not exist"):
        unseal(path)
    seal(path, TRUTH)
    assert unseal(path) == TRUTH
    with pytest.raises(BadInput, match="a new name expected"):
        seal(path, {})
    wrapper = json.loads(path.read_text())
    wrapper["sealed"] = wrapper["sealed"][:-8] + "AAAAAAA="
    path.write_text(json.dumps(wrapper))
    with pytest.raises(BadInput, match="was changed"):
        unseal(path)
    path.write_text(text)
    with pytest.raises(BadInput, match="sealed file"):
        unseal(path)
