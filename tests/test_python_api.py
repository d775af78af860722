"""Python API: the session of docs/reference/python.md, invalid input, and light imports."""

import pickle
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

import ident
from daq.program import program as daq_program
from ident.program import program as ident_program
from tests.documents import ROOT
from tests.running import printed

SAMPLES = ROOT / "recordings" / "samples"


@pytest.mark.slow
def test_session_in_the_documentation_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("fig5a.mcap", "fig5b.mcap"):
        shutil.copy(SAMPLES / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(
        r"^```python\n(.*?)^```$", (ROOT / "docs" / "reference" / "python.md").read_text(), re.MULTILINE | re.DOTALL
    )
    session: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, "docs/reference/python.md", "exec"), session)
    assert session["diagnosis"].verdict == "adequate"
    assert session["better"].effects == ("rod_inertia",)
    pickled = pickle.dumps(session["diagnosis"])
    assert len(pickled) < 2_000_000
    assert pickle.loads(pickled).model.parameters == session["diagnosis"].model.parameters
    steps = session["diagnosis"].document.steps
    assert max(steps[-1].held_out_rms) < 0.3 * min(steps[0].held_out_rms)
    assert session["torque"].shape == session["voltage"].shape == (1001, 3)
    assert session["inertia"].shape == (1001, 3, 3)
    assert "inertia_coupling" in session["terms"]
    assert abs(session["acceleration"] - session["qdd"]).max() < 1e-6
    with pytest.raises(ident.BadInput, match=r"nothing\.mcap"):
        ident.fit(["nothing.mcap"])


def test_the_version_is_that_of_the_programs() -> None:
    assert ident.__version__ == version("delta-workbench")
    for program in (ident_program, daq_program):
        assert ident.__version__ in printed(program, "--version")


def test_the_interface_is_all_that_is_listed() -> None:
    ident.check  # noqa: B018
    assert sorted(dir(ident)) == sorted(ident.__all__)
    assert all(hasattr(ident, name) for name in dir(ident))
    documented = {"BadInput", "Model", "Recording", "RunFailed", "check", "compare", "diagnose", "fit", "load_model"}
    assert {*dir(ident)} == documented | {"read", "__version__"}


def test_import_is_light() -> None:
    heavy = ("importlib.metadata", "scipy", "numba", "matplotlib", "pydantic", "plotly")
    code = f"import sys, ident; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ident.fit([]), "at least one recording expected"),
        (lambda: ident.load_model("."), "Is a directory"),
        (lambda: ident.fit("a.mcap", effects=["stribek"]), "stribeck"),
        (lambda: ident.fit(["a.mcap"], intervals="foo"), "intervals: one of stationary, hac"),  # type: ignore[arg-type]
        (lambda: ident.fit(["a.mcap"], seed=-1), "a seed of 0 or more"),
        (lambda: ident.fit(["a.mcap"], method="magic"), "pso"),
        (lambda: ident.check("a.mcap", share=0), "share: more than 0"),
        (lambda: ident.fit(["a.mcap"], settings={"colour": "red"}), "'colour'"),
    ],
)
def test_values_that_cannot_be_are_refused(call: Callable[[], object], message: str) -> None:
    with pytest.raises(ident.BadInput, match=message):
        call()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: ident.fit([None]), "files: a path, a recording, or a list"),  # type: ignore[list-item]
        (lambda: ident.fit("a.mcap", effects=[3]), "effects: a name or a list"),  # type: ignore[list-item]
        (lambda: ident.compare("a.json", ["a.mcap"]), "model: a model of"),  # type: ignore[arg-type]
        (lambda: ident.diagnose(["a.mcap"], model="a.json"), "model: a model of"),  # type: ignore[arg-type]
        (lambda: ident.fit("a.mcap", cutoff="30"), "cutoff: a number"),  # type: ignore[arg-type]
        (lambda: ident.diagnose("a.mcap", cutoff="30"), "cutoff: a number"),  # type: ignore[arg-type]
        (lambda: ident.fit("a.mcap", cutoff=True), "cutoff: a number"),
        (lambda: ident.fit("a.mcap", seed=1.5), "seed: a whole number"),  # type: ignore[arg-type]
        (lambda: ident.fit("a.mcap", settings=[1]), "settings: a mapping"),  # type: ignore[arg-type]
        (lambda: ident.fit("a.mcap", progress=3), "progress: a function"),  # type: ignore[arg-type]
        (lambda: ident.check("a.mcap", share="3"), "share: a number"),  # type: ignore[arg-type]
        (lambda: ident.read("a.csv", map=["t"]), "map: a mapping"),  # type: ignore[arg-type]
        (lambda: ident.fit("a.mcap", "b.mcap"), "positional"),  # type: ignore[misc]
        (lambda: ident.fit("a.mcap", colour="red"), "colour"),  # type: ignore[call-arg]
    ],
)
def test_arguments_of_the_wrong_type_are_named(call: Callable[[], object], message: str) -> None:
    with pytest.raises(TypeError, match=message):
        call()
