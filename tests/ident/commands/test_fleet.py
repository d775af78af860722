"""The commands as a user types them, on recordings of one robot whose friction rises."""

import json
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import pytest

from ident.cli import program
from recordings.recording import Floats, Recording
from tests import running
from tests.conftest import Runner

FIRST = datetime(2026, 1, 5, 22, tzinfo=UTC)
NIGHTS, SINCE = 10, 6


invoke = partial(running.invoke, program, "fleet")


@pytest.fixture(scope="module")
def folder(
    make: Callable[..., Recording],
    write: Callable[[Recording], Path],
    truth: Floats,
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    """Recordings of ten nights; from the seventh on, joint 2 has more dry friction."""
    place = tmp_path_factory.mktemp("recordings")
    worn = truth.copy()
    worn[9] *= 1.2
    for night in range(NIGHTS):
        path = place / f"{night}.mcap"
        made = make(
            cycles=1, rate=250.0, noise=0.01, seed=night, path=path, parameters=worn if night >= SINCE else truth
        )
        start = (FIRST + timedelta(days=night)).isoformat()
        write(replace(made, run=made.run.model_copy(update={"start": start, "robot": "r07"})))
    (place / "broken.mcap").write_bytes(b"")
    return place


@pytest.mark.slow
def test_a_whole_night_from_recordings_to_an_acknowledged_alarm(folder: Path, tmp_path: Path, ident: Runner) -> None:
    store, page = tmp_path / "store", tmp_path / "fleet.html"
    run = ident("fleet", folder, "--store", store, "--json", "--engine", "processes", "--workers", 2)
    assert run.code == 3
    document = json.loads(run.out)
    assert document["recordings"] == {"seen": NIGHTS + 1, "new": NIGHTS + 1, "failed": 1}
    (alarm,) = document["alarms"]
    assert (alarm["robot"], alarm["kind"], alarm["verdict"]) == ("r07", "sudden", "missing-effect")
    assert "coulomb_friction" in (alarm["effect"], *alarm["confusable_with"])
    assert alarm["joints"] == [2]
    assert alarm["since"] == "2026-01-11"
    assert alarm["origin"] == "mechanics"
    assert run.err.splitlines()[-1].startswith("next: ident fleet report --store")
    report = ident("fleet", "report", "--store", store, "-o", page)
    assert report.code == 0
    assert f"next: ident fleet ack {alarm['id']}" in report.err
    assert "1 alarm is open" in page.read_text(encoding="utf-8")
    assert ident("fleet", "ack", alarm["id"], "--store", store, "--note", "known").code == 0
    again = ident("fleet", folder, "--store", store, "--json")
    assert again.code == 0
    assert json.loads(again.out)["recordings"]["new"] == 0
    assert json.loads(again.out)["alarms"][0]["note"] == "known"


def test_few_nights_have_no_alarm(folder: Path, tmp_path: Path) -> None:
    place = tmp_path / "recordings"
    place.mkdir()
    (place / "0.mcap").symlink_to(folder / "0.mcap")
    done = invoke(place, "--store", tmp_path / "store", "--engine", "serial")
    assert done.exit_code == 0, done.output
    assert "1 recordings, 1 of them new; 0 cannot be used" in done.output
    assert "no alarms" in done.output


def test_first_argument_may_be_an_option_or_a_folder_named_like_a_command(tmp_path: Path) -> None:
    (tmp_path / "report").mkdir()
    done = invoke("--store", tmp_path / "store", tmp_path / "report")
    assert done.exit_code == 0, done.output
    assert "FOLDER..." in invoke("--help").output
