"""A folder of pictures is written completely or not at all; each joint has its colour of the palette."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from ident.data.prepared_recording import prepare
from ident.output import pictures, torque_picture
from ident.output.pictures import staged_folder
from recordings.recording import Recording
from web.palette import JOINTS, NOISE


def test_the_model_of_each_joint_has_the_joints_colour(make: Callable[..., Recording], tmp_path: Path) -> None:
    recording = make("fig5b", cycles=1, rate=250.0)
    prepared = prepare(recording, "parallel", None)
    pictures.torque(tmp_path / "t.png", "", prepared, [{"model": 0.5 * prepared.torque}])
    pixels = image.imread(tmp_path / "t.png")[..., :3]
    rows = np.array_split(pixels[round(0.05 * len(pixels)) :], 3)

    def drawn(colour: str) -> list[bool]:
        return [bool((np.abs(row - to_rgb(colour)).max(axis=2) < 0.02).sum() > 20) for row in rows]

    for joint, colour in enumerate(JOINTS[:3]):
        # The legend above the first row has its colours too.
        assert drawn(colour) == [joint == row for row in range(3)]
    assert drawn(NOISE) == [False] * 3


def test_an_interrupted_write_leaves_no_files(tmp_path: Path) -> None:
    def interrupted() -> None:
        with staged_folder(tmp_path / "plots") as folder:
            (folder / "first.png").touch()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []


def test_finished_pictures_are_added_to_the_folder(tmp_path: Path) -> None:
    plots = tmp_path / "deep" / "plots"
    for name in ("first.png", "second.png"):
        with staged_folder(plots) as folder:
            (folder / name).touch()
            assert not (plots / name).exists()
    assert sorted(path.name for path in plots.iterdir()) == ["first.png", "second.png"]
    assert list(plots.parent.iterdir()) == [plots]


@pytest.mark.parametrize("with_intervals", [True, False])
def test_every_joint_and_cause_is_drawn(
    with_intervals: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bars: list[list[str]] = []
    original = Axes.barh
    monkeypatch.setattr(
        Axes, "barh", lambda self, y, *rest, **options: bars.append(list(y)) or original(self, y, *rest, **options)
    )
    time = np.arange(50) / 10
    terms = {"gravity": np.outer(np.cos(time), [1.0, -2.0]), "coulomb": np.outer(np.sign(np.sin(time)), [1.0, 1.0])}
    rms = {name: np.sqrt((values**2).mean(axis=0)) for name, values in terms.items()}
    widths = {name: np.array([0.1, np.nan]) for name in terms} if with_intervals else None
    out = tmp_path / "a.part"
    torque_picture.draw(out, "a path", time, np.sum(list(terms.values()), axis=0), terms, rms, widths, ("N m", "N"))
    assert bars == [["gravity", "coulomb"]] * 2
    assert out.read_bytes().startswith(b"\x89PNG")
