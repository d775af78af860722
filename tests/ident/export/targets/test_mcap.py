"""The export to MCAP, opened by other libraries."""

import json
import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.summary import Summary
from rosbags.highlevel import AnyReader

import ident
from ident.commands.export import command
from recordings.errors import BadInput
from recordings.reader import read
from tests.ident.kept_models import MODELS
from tests.running import ran
from tests.transforms import poses, rod_errors

MODEL, SAMPLE = MODELS / "stribeck.model.json", MODELS / "fig5a.mcap"
ROOT = Path(ident.__file__).parents[1]
run = partial(ran, command)


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("export") / "seen.mcap"
    run(MODEL, "--to", "mcap", "--on", SAMPLE, "-o", out)
    return out


@pytest.fixture(scope="module")
def topics(exported: Path) -> dict[str, list]:
    """Messages by topic, as rosbags reads them."""
    found: dict[str, list] = {}
    with AnyReader([exported]) as reader:
        for connection, log, payload in reader.messages():
            found.setdefault(connection.topic, []).append((log, reader.deserialize(payload, connection.msgtype)))
    return found


def efforts(messages: list) -> np.ndarray:
    return np.array([message.effort for _, message in messages])


def test_residual_and_causes_are_those_of_the_comparison(topics: dict[str, list]) -> None:
    model = ident.load_model(MODEL)
    [prediction] = ident.compare(model, SAMPLE).predictions
    assert efforts(topics["/residual"]) == pytest.approx(prediction.residual, abs=1e-9, nan_ok=True)
    causes = [efforts(messages) for topic, messages in topics.items() if topic.startswith("/causes/")]
    assert len(causes) == 7
    known = np.isfinite(prediction.residual)
    assert np.sum(causes, axis=0)[known] == pytest.approx(prediction.computed[known], abs=1e-9)
    assert model.file.residual_test is None
    assert np.isnan(efforts(topics["/floor"])).all()


def test_the_robot_moves_with_rods_of_constant_length(topics: dict[str, list]) -> None:
    assert len(topics["/robot_description"]) == len(topics["/tf_static"]) == 1
    fixed = topics["/tf_static"][0][1].transforms
    moving = topics["/tf"]
    assert np.diff([log for log, _ in moving]).min() > 1.5e7
    rig = read(SAMPLE).rig
    errors = [rod_errors(poses([*fixed, *message.transforms]), rig.geometry.L2) for _, message in moving[::25]]
    assert np.abs(errors).max() < 1e-9


def panels_in(tree: dict | str) -> set[str]:
    return {tree} if isinstance(tree, str) else panels_in(tree["first"]) | panels_in(tree["second"])


def test_the_layout_shows_topics_that_exist(topics: dict[str, list]) -> None:
    layout = json.loads((ROOT / "daq" / "live" / "assets" / "foxglove-layout.json").read_text(encoding="utf-8"))
    panels = layout["configById"]
    assert panels_in(layout["layout"]) == set(panels)
    paths = [
        path["value"] for name, panel in panels.items() if name != "Plot!live" for path in panel.get("paths", [])
    ]
    assert len(paths) == 6
    for path in paths:
        topic, field, index = re.fullmatch(r"(/[\w/]+)\.(\w+)\[(\d)\]", path).groups()
        assert len(getattr(topics[topic][0][1], field)) > int(index), path
    assert panels["3D!robot"]["layers"]["robot"]["topic"] in topics


def _counts(summary: Summary) -> dict[str, int]:
    counts = summary.statistics.channel_message_counts
    return {channel.topic: counts.get(key, 0) for key, channel in summary.channels.items()}


def test_the_recording_is_in_it(exported: Path) -> None:
    with SAMPLE.open("rb") as old, exported.open("rb") as new:
        before, after = make_reader(old).get_summary(), make_reader(new, validate_crcs=True).get_summary()
    old_counts, new_counts = (_counts(summary) for summary in (before, after))
    assert {topic: count for topic, count in old_counts.items() if count}.items() <= new_counts.items()
    assert read(exported).position == pytest.approx(read(SAMPLE).position, nan_ok=True)


def test_a_motion_without_a_recording_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        BadInput, match="export to mcap: the file of a recording expected, fig5a found; give it as --on FILE"
    ):
        run(MODEL, "--to", "mcap", "--traj", "fig5a", "-o", tmp_path / "a.mcap")
    assert not list(tmp_path.iterdir())
