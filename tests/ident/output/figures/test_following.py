from dataclasses import replace
from pathlib import Path

import numpy as np

from ident.output.figures.following import over_time
from recordings.reader import read

SAMPLE = Path(__file__).parents[4] / "recordings" / "samples" / "fig5b.mcap"


def test_each_joint_shows_every_run() -> None:
    recording = read(SAMPLE)
    still = replace(recording, position=recording.position * np.nan)
    figure = over_time({"plain": recording, "fed": still})
    assert [trace.name for trace in figure.data] == ["plain"] * 3 + ["fed"] * 3
    worst = 1e3 * np.nanmax(np.abs(recording.following_error[recording.repeat >= 0][:, 1]))
    assert np.isclose(np.nanmax(np.abs(figure.data[1].y)), worst)
    assert figure.layout.yaxis.title.text.endswith("[mrad]")
