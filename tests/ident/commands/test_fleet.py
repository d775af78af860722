"""The commands as a user types them, on recordings of one robot whose friction rises."""

import json
import shlex
import sys
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from ident.program import program
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from tests import running
from tests.conftest import Runner
from tests.ident.fleet.conftest import filled, rows_of, saved

FIRST = datetime(2026, 1, 5, 22, tzinfo=UTC)
NIGHTS, SINCE = 10, 6


invoke = partial(running.ran, program, "fleet")


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
    store, page, told = tmp_path / "store", tmp_path / "fleet.html", tmp_path / "told"
    teller = tmp_path / "tell.py"
    teller.write_text("import sys\nopen(sys.argv[1], 'a').write(sys.stdin.read() + '\\n')\n")
    heard = ("--on-alarm", shlex.join([sys.executable, str(teller), str(told)]))
    run = ident("fleet", folder, "--store", store, "--json", "--engine", "processes", "--workers", 2, *heard)
    assert run.code == 3
    assert f"not used: recording {folder / 'broken.mcap'} is empty" in run.err
    document = json.loads(run.out)
    assert document["recordings"] == {"seen": NIGHTS + 1, "new": NIGHTS + 1, "failed": 1}
    (alarm,) = document["alarms"]
    assert (alarm["robot"], alarm["kind"], alarm["verdict"]) == ("r07", "sudden", "missing-effect")
    assert "coulomb_friction" in (alarm["effect"], *alarm["confusable_with"])
    assert alarm["joints"] == [2]
    assert alarm["since"] == "2026-01-11"
    assert alarm["origin"] == "mechanics"
    assert run.err.splitlines()[-1].startswith("next: ident fleet report --store")
    assert ident("fleet", folder, "--store", store, *heard).code == 3
    assert [json.loads(line) for line in told.read_text().splitlines()] == [alarm], "each alarm once"
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
    assert "1 recordings, 1 of them new; 0 cannot be used" in done.output
    assert "no alarms" in done.output


def test_rebuild_makes_the_state_anew(tmp_path: Path) -> None:
    store = filled(tmp_path / "store", rows_of("r07", {"c_c1": np.ones(3)}))
    saved(store)
    (state,) = (store.folder / "state").rglob("r07.json")
    before = state.read_bytes()
    state.unlink()
    report = ("report", "--store", store.folder, "-o", tmp_path / "fleet.html")
    with pytest.raises(BadInput, match="`ident fleet rebuild --store"):
        invoke(*report)
    assert "next: ident fleet recordings --store" in invoke("rebuild", "--store", store.folder).output
    assert state.read_bytes() == before
    invoke(*report)


def test_first_argument_may_be_an_option_or_a_folder_named_like_a_command(tmp_path: Path) -> None:
    (tmp_path / "report").mkdir()
    invoke("--store", tmp_path / "store", tmp_path / "report")
    assert "FOLDER..." in invoke("--help").output
