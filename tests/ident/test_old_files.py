"""Models and effect files of an earlier version load unchanged and give the same numbers.

The files in `old_files` are never regenerated. They were made as follows, with `worn_a` and `worn_b` recorded with
--sim worn.toml, --cycles 2 and --rate 250:

    fig5a, fig5b        the samples of that version
    stribeck            ident fit fig5a.mcap --with stribeck, of these
    signal, stateful    as that, with actuation_delay, with joint_elasticity:2
    rls, lad            ident fit fig5a.mcap --method rls, --method lad
    diagnosed, learned  ident diagnose worn_a.mcap --validate worn_b.mcap --apply --learn learned.py, which writes
                        a model and an effect file; then the fit that it proposes, which writes learned.model.json
    tight_spot          ident fit worn_a.mcap --with tight_spot:2 --effect-file tight_spot.py, a copy of docs/examples
    slide               ident fit --with torque_offset of one prismatic axis, imported from slide(seed=0)
"""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Runner

OLD = Path(__file__).parent / "old_files"
CLOSE = 1e-6

RMS = {
    "stribeck": (0.3038424240, 0.3041470705, 0.2994382823),
    "signal": (0.3122266802, 0.3173150341, 0.3114524618),
    "stateful": (0.3137683365, 0.3386151611, 0.3185965743),
    "rls": (2.3433709444, 2.4328363679, 2.2749578154),
    "lad": (0.3128458580, 0.3175361807, 0.3123905228),
    "diagnosed": (0.0433977774, 0.2830873297, 0.0461333114),
    "learned": (0.0663106142, 0.6827185464, 0.0683650591),
    "tight_spot": (0.3094942474, 0.7963022714, 0.3120260548),
}
"""RMS residual of each joint on fig5b.mcap [N m]. That of Stribeck friction has changed by up to 0.2 % since it is
averaged over each sample, as drives report it."""
FILES = {"learned": OLD / "learned.py", "tight_spot": OLD / "tight_spot.py"}
"""Files of effects that are not in the library."""
FAST = ("learned",)
"""The others have the marker `slow`: each runs a program that draws pictures."""


def model(name: str) -> Path:
    return OLD / f"{name}.model.json"


def effect_file(name: str) -> list[object]:
    """Return the option --effect-file, if the model needs it."""
    return ["--effect-file", FILES[name]] if name in FILES else []


def slide(path: Path, seed: int) -> Path:
    """The measurements of one prismatic axis whose force follows Newton's law, friction and a constant."""
    rng = np.random.default_rng(seed)
    time = np.arange(3000) * 4e-3
    omega = np.array([2.0, 5.0, 9.0])
    angle = np.outer(time, omega) + rng.uniform(0, 6, 3)
    x, v = 0.1 * np.sin(angle).sum(axis=1), 0.1 * (omega * np.cos(angle)).sum(axis=1)
    a = -0.1 * (omega**2 * np.sin(angle)).sum(axis=1)
    force = 3.0 * a + 4.0 * v + 1.5 * np.sign(v) + 0.7 + rng.normal(0, 0.05, time.shape)
    table = np.column_stack([time, x, force])
    np.savetxt(path, table, fmt="%.9f", delimiter=",", header="time,position_1,effort_1", comments="")
    return path


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in FAST else pytest.mark.slow) for n in RMS])
def test_old_models_give_the_same_residual(ident: Runner, name: str) -> None:
    result = ident("compare", model(name), OLD / "fig5b.mcap", *effect_file(name), "--json")
    assert result.code == 0, result.err
    assert [joint["rms_all"] for joint in json.loads(result.out)["joints"]] == pytest.approx(RMS[name], rel=CLOSE)


@pytest.mark.slow
def test_an_old_model_of_another_mechanism_gives_the_same_residual(
    daq: Runner, ident: Runner, tmp_path: Path
) -> None:
    table = slide(tmp_path / "slide.csv", seed=1)
    assert daq("import", table, "--out", "slide.mcap", "--mechanism", "axes", "--joints", "prismatic").code == 0
    result = ident("compare", model("slide"), "slide.mcap", "--json")
    assert result.code == 0, result.err
    assert json.loads(result.out)["joints"][0]["rms_all"] == pytest.approx(0.0549399699, rel=CLOSE)


@pytest.mark.parametrize("name", FILES)
def test_old_effect_files_are_listed(ident: Runner, name: str) -> None:
    result = ident("effects", name, *effect_file(name))
    assert result.code == 0, result.err
    assert name in result.out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rms"),
    [
        ("learned", (0.1297681175, 0.1380625912, 0.1439682746)),
        ("tight_spot", (0.1298056680, 0.1337919963, 0.1439411294)),
    ],
)
def test_old_effect_files_are_fitted(ident: Runner, tmp_path: Path, name: str, rms: tuple[float, ...]) -> None:
    outputs = ["-o", tmp_path / "new.model.json"]
    recording = OLD / "fig5a.mcap"
    options = ["--method", "ls", "--with", f"{name}:2", "--without", "rod_inertia", "--cutoff", "30"]
    options += [*effect_file(name), *outputs]
    result = ident("fit", recording, *options, "--json")
    assert result.code == 0, result.err
    assert json.loads(result.out)["train"]["fitted"]["rms"] == pytest.approx(rms, rel=CLOSE)


@pytest.mark.slow
def test_a_diagnosis_starts_from_an_old_model(ident: Runner) -> None:
    options = ["--model", model("tight_spot"), *effect_file("tight_spot")]
    result = ident("diagnose", OLD / "fig5a.mcap", "--validate", OLD / "fig5b.mcap", *options, "--json")
    assert result.code == 0, result.err
    document, rms = json.loads(result.out), (0.3079087039, 0.3146944022, 0.2953723600)
    assert document["verdict"] == "adequate"
    assert "tight_spot" in document["steps"][0]["effects"]
    assert document["steps"][0]["held_out_rms"] == pytest.approx(rms, rel=CLOSE)
