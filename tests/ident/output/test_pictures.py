"""A folder of pictures is written completely or not at all; each joint has its colour of the palette."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
from matplotlib import image
from matplotlib.colors import to_rgb

from delta_web.palette import JOINTS, NOISE
from ident.data.prepared_recording import prepare
from ident.output import pictures
from ident.output.pictures import staged_folder
from recordings.recording import Recording


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


def test_finished_pictures_are_added_to_the_folder_and_an_interrupted_write_leaves_no_files(tmp_path: Path) -> None:
    plots = tmp_path / "deep" / "plots"
    for name, error in (("first.png", None), ("lost.png", KeyboardInterrupt), ("second.png", None)):
        with suppress(KeyboardInterrupt), staged_folder(plots) as folder:
            (folder / name).touch()
            assert not (plots / name).exists()
            if error:
                raise error
    assert sorted(path.name for path in plots.iterdir()) == ["first.png", "second.png"]
    assert list(plots.parent.iterdir()) == [plots]
