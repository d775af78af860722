"""The proposed command: its options, and what it lacks."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from daq.commands.import_ import command
from recordings.importing.columns import guess
from recordings.importing.proposal import missing, options, propose
from recordings.importing.table import Table
from tests.running import printed

TIME = np.arange(400) * 0.004
ANGLE, SPEED = np.sin(TIME), np.cos(TIME)


def table_of(columns: dict[str, np.ndarray], units: dict[str, str] | None = None) -> Table:
    return Table(Path("data.csv"), columns, units or {})


def test_unknown_torque_per_ampere_is_for_the_user_to_put_in() -> None:
    table = table_of({"t": TIME, "q": ANGLE, "iq": SPEED})
    guesses = guess(table)
    assert options(table, guesses)[-2:] == ["--kt", "NUMBER"]
    assert [sentence.partition(":")[0] for sentence in missing(guesses)] == ["--kt NUMBER"]
    for known in (["--kt", "0.3"], ["--rig", "rig.toml"]):
        assert "--kt" not in options(table, guesses, known)
        assert missing(guesses, known) == []


def test_counts_and_shares_need_what_they_are_of() -> None:
    table = table_of({"t": TIME, "q": np.rint(50_000 * ANGLE), "torque": SPEED}, {"torque": "%"})
    sentences = missing(guess(table))
    assert sentences[0].startswith("counts need the counts per turn")
    assert sentences[1].startswith("% needs the torque at 100 %")
    assert missing(guess(table), ["--rig", "rig.toml"]) == []


def test_what_no_column_looks_like_is_missing() -> None:
    sentences = missing(guess(table_of({"a": np.zeros(3)})))
    assert [sentence.partition(":")[0] for sentence in sentences] == [
        "no column increases as time does",
        "no column looks like a position",
        "no torque, current or voltage",
    ]


@pytest.mark.parametrize(("header", "prefix"), [("t,q,tau", "next: daq import "), ("a,b,c", "complete it and run: ")])
def test_command_that_lacks_something_is_not_what_comes_next(header: str, prefix: str, tmp_path: Path) -> None:
    rows = "\n".join(f"{0.01 * k},{k % 5},{k % 3}" for k in range(30))
    (tmp_path / "a.csv").write_text(f"{header}\n{rows}\n")
    lines = list(propose(tmp_path / "a.csv", ["--robot", "r 7"]).lines())
    assert lines[-1].startswith(prefix)
    assert lines[-1].endswith("--robot 'r 7'")


def test_document_previews_the_columns(tmp_path: Path) -> None:
    rows = "\n".join(f"{0.01 * k},{k % 5 if k else ''},on" for k in range(1000))
    (tmp_path / "a.csv").write_text(f"t,q,state\n{rows}\n")
    time, angle, state = propose(tmp_path / "a.csv").as_json()["columns"]
    assert (time["name"], angle["name"], state["name"]) == ("time", "position_1", None)
    assert (time["preview"][0], time["preview"][-1], len(time["preview"])) == (0.0, 9.99, 300)
    assert angle["preview"][0] is None
    assert state["preview"] == []


def test_accepted_guess_is_the_pasted_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    rows = "\n".join(f"{20 * k},{np.sin(0.1 * k):.5f},{k % 3}" for k in range(60))
    Path("a.csv").write_text(f"t [ms],q,tau\n{rows}\n")
    document = json.loads(printed(command, "a.csv", "--guess", "--yes", "--json"))
    assert (document["recording"], document["joints"], document["samples"]) == ("a.mcap", 1, 60)
    pasted = propose(Path("a.csv")).command
    printed(command, *shlex.split(pasted)[2:])
    assert Path("a.mcap").read_bytes() == Path("a-2.mcap").read_bytes()
    assert propose(Path("a.csv")).arguments[:3] == ["a.csv", "--out", "a-3.mcap"]


@pytest.mark.parametrize(
    ("units", "expected"),
    [
        (("mm", "mm", "mm"), ["--mechanism", "axes", "--joints", "prismatic"]),
        (("mm", "deg", "deg"), ["--mechanism", "axes", "--joints", "prismatic,revolute,revolute"]),
        (("deg", "deg", "deg"), []),
        (("deg",), ["--mechanism", "axes"]),
    ],
)
def test_slides_are_told_by_their_unit(units: tuple[str, ...], expected: list[str]) -> None:
    columns = {"time": TIME, **{f"position_{k}": ANGLE for k in range(1, 1 + len(units))}, "effort_1": SPEED}
    table = table_of(columns, {f"position_{k}": unit for k, unit in enumerate(units, start=1)})
    assert options(table, guess(table)) == expected
