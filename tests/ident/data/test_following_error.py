from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.data.following_error import following
from recordings.errors import BadInput
from recordings.reader import read

SAMPLE = Path(__file__).parents[3] / "recordings" / "samples" / "fig5a.mcap"


def test_following_error_of_a_sample_is_that_of_its_joints() -> None:
    result = following(read(SAMPLE))
    assert (result.rms < result.worst).all()
    assert 1e-4 < result.overall < 0.01
    assert result.platform_rms is not None
    assert result.platform_worst is not None
    # A platform moves about as far as an elbow 0.34 m from its joint.
    assert 0.1 < result.platform_rms / result.overall < 1.0
    assert result.platform_rms < result.platform_worst


def test_recording_without_repetitions_is_refused() -> None:
    recording = read(SAMPLE)
    with pytest.raises(BadInput, match=r"fig5a\.mcap: targets and positions"):
        following(replace(recording, repeat=np.full_like(recording.repeat, -1)))
