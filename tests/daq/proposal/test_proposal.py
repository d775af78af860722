"""Rig files proposed from EDS and DCF files: what they say, and what they leave to the user."""

import tomllib
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings

from daq.proposal.choices import common_torque_source, torque_sources
from daq.proposal.document import RigProposal, propose
from daq.proposal.facts import DriveFacts, from_file
from daq.proposal.names import motor_voltage
from recordings.buses import CanBus
from recordings.errors import BadInput
from recordings.rig import Rig, load_rig
from tests.drivers.simulated.dictionaries import (
    CURRENT,
    I32,
    MADE_UP,
    RATED_TORQUE,
    TORQUE,
    U16,
    U32,
    Item,
    MadeUpDrive,
    base,
    made_up_drives,
)

BUS = CanBus(interface="socketcan", channel="can0")


def facts_of(folder: Path, made_up: MadeUpDrive, node: int = 1) -> DriveFacts:
    path, _ = made_up.write(folder, f"drive-{node}")
    return from_file(path, node)


def proposal(folder: Path, items: Any, nodes: tuple[int, ...] = (1, 2, 3)) -> RigProposal:
    return propose([facts_of(folder, MadeUpDrive(items), node) for node in nodes], BUS)


GEARED = {(0x6091, 1): Item(U32, default=21), (0x6091, 2): Item(U32, default=1)}


def test_ratings_become_the_torque_at_the_joint(tmp_path: Path) -> None:
    drive = proposal(tmp_path, base() | TORQUE | GEARED).rig.drives[0]
    assert (drive.torque_source, drive.rated_torque) == ("torque_actual", pytest.approx(RATED_TORQUE / 1000 * 21))


def test_control_characters_of_a_name_do_not_break_the_file(tmp_path: Path) -> None:
    drives = [facts_of(tmp_path, MadeUpDrive(base() | TORQUE), node) for node in (1, 2, 3)]
    named = [replace(facts, name="Drive\r\nrate = 1") for facts in drives]
    assert "Drive??rate = 1" in propose(named, BUS).text


def test_a_current_needs_the_torque_constant(tmp_path: Path) -> None:
    rated = base() | CURRENT | {(0x6076, 0): TORQUE[0x6076, 0]}
    stated = proposal(tmp_path, rated | GEARED)
    assert stated.rig.torque.per_ampere == pytest.approx((952 / 4200 * 21,) * 3, rel=1e-5)
    assert "stated: N m/A; 6076h / 6075h * gear" in stated.text
    silent = proposal(tmp_path, base() | CURRENT)
    assert silent.rig.drives[0].rated_current == pytest.approx(4.2)
    assert "unknown: N m/A; torque constant of the motor [N m/A]" in silent.text
    for document in (silent, proposal(tmp_path, rated)):
        assert tomllib.loads(document.text)["torque"]["per_ampere"] == ["?"] * 3
        assert document.asks


@pytest.mark.parametrize(
    ("text", "asks"),
    [
        ('per_ampere = ["?", "?"]', True),
        ('[[drives]]\ngear = "?"', True),
        ('voltage = { scale = "?" }', True),
        ('name = "a"  # in place of "?"\n# gear = "?"', False),
    ],
)
def test_only_a_value_in_use_is_asked_for(text: str, asks: bool) -> None:
    assert RigProposal(text, (), Rig(name="any")).asks is asks


def test_what_nothing_states_is_asked_for_and_no_command_takes_it(tmp_path: Path) -> None:
    """base() states neither encoder nor gear, nor the unit of acceleration."""
    document = proposal(tmp_path, base() | {(0x6077, 0): TORQUE[0x6077, 0]})
    drive = tomllib.loads(document.text)["drives"][0]
    asked = {"counts_per_turn", "gear", "rated_torque"}
    assert {key for key, value in drive.items() if value == "?"} == asked
    assert drive["units"] == {"acceleration": "?"}
    assert all(any(note.startswith(key) for note in document.notes) for key in asked)
    assert 'counts/s^2" }' not in document.text
    path = tmp_path / "rig.toml"
    path.write_text(document.text)
    with pytest.raises(BadInput, match=r"'drives.0.counts_per_turn' is \"\?\": nothing states it") as refused:
        load_rig(path)
    assert "(and 11 more: drives.0.gear, " in str(refused.value)
    assert str(refused.value).endswith("drives.2.units.acceleration)")


@pytest.mark.parametrize(
    ("values", "shown"),
    [
        ({}, "6065h = 2000 would be 2000 turns of the motor"),
        ({(0x6065, 0): 50}, "its other values do not decide"),
        ({(0x6065, 0): 0, (0x607D, 1): -100, (0x607D, 2): 100}, "by 608Fh, 607Dh = 200 would be 0.02441"),
    ],
)
def test_a_resolution_beside_unset_factors_is_assumed(
    values: dict[tuple[int, int], int], shown: str, tmp_path: Path
) -> None:
    items = dict(MADE_UP["unset_factors"].items)
    items |= {address: replace(items[address], default=value) for address, value in values.items()}
    document = proposal(tmp_path, items)
    assert document.rig.drives[0].counts_per_turn == 8192
    (note,) = [note for note in document.notes if note.startswith("counts_per_turn")]
    assert "8192 by 608Fh, 1 by 6092h and 6091h: either may be right" in note
    assert shown in note
    assert "# assumed: position units per turn of the motor, by 608Fh" in document.text


@pytest.mark.parametrize(
    ("name", "scale"),
    [
        ("Motor voltage [mV]", 0.001),
        ("output voltage in 0.1 V", 0.1),
        ("Terminal voltage", None),
        ("DC bus voltage", ...),
        ("Motor over-voltage threshold", ...),
        ("motor current", ...),
        ("Analog output 1 voltage", ...),
        ("Voltage phase A", ...),
        ("Motor supply voltage", ...),
    ],
)
def test_the_motor_voltage_is_found_by_its_name(name: str, scale: object, tmp_path: Path) -> None:
    items = base() | {(0x2100, 0): Item(I32, "ro", mappable=scale is None, name=name)}
    voltage = motor_voltage(facts_of(tmp_path, MadeUpDrive(items)))
    assert (... if voltage is None else voltage.scale) == scale
    if voltage is not None:  # one that cannot be mapped is polled
        document = proposal(tmp_path, items)
        assert ('scale = "?"' in document.text) == (scale is None)
        drive = document.rig.drives[0]
        assert drive.voltage.transfer == ("pdo" if scale is None else "sdo")


def test_torque_comes_before_current_and_both_before_a_voltage(tmp_path: Path) -> None:
    voltage = {(0x2100, 0): Item(I32, "ro", mappable=True, name="Motor voltage [mV]")}
    unrated = {(0x6077, 0): TORQUE[0x6077, 0]}
    facts = [facts_of(tmp_path, MadeUpDrive(base() | items)) for items in (TORQUE, voltage | CURRENT | unrated)]
    assert torque_sources(facts[1]) == ["torque_actual", "current_actual", "voltage"]
    assert common_torque_source(facts) == "torque_actual"


def test_no_torque_source_is_refused_with_what_may_be_done(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"nothing to find the torque from.*6077:00.*6078:00.*manual"):
        proposal(tmp_path, MADE_UP["outputs_only"].items)
    facts = [facts_of(tmp_path, MadeUpDrive(base() | items)) for items in (TORQUE, CURRENT)]
    with pytest.raises(BadInput, match="none in common"):
        common_torque_source(facts)


def test_what_needs_a_decision_is_commented_out(tmp_path: Path) -> None:
    items = {a: item for a, item in (base() | TORQUE).items() if a[0] not in (0x1016, 0x6502, 0x6007)}
    text = proposal(tmp_path, items).text
    assert '# accept_missing = ["1016", "6007"]' in text
    assert "- 1016:01 watchdog on the master: no such object; the drive does not stop when this program or" in text
    assert "# assume_mode = true" in text
    drive = tomllib.loads(text)["drives"][0]
    assert not {"accept_missing", "assume_mode"} & set(drive)


def test_touch_probe_and_safe_torque_off_are_offered(tmp_path: Path) -> None:
    states = {(0x60B9, 0): Item(U16, "ro"), (0x2F00, 3): Item(U32, "ro", name='"STO" status')}
    assert "watched" not in proposal(tmp_path, base() | TORQUE).text
    text = proposal(tmp_path, base() | TORQUE | states).text
    line = next(line for line in text.splitlines() if line.startswith("# watched"))
    first, second = tomllib.loads(line.removeprefix("# "))["watched"]
    assert first == {"index": 0x60B9, "name": "touch probe status"}
    assert (second["index"], second["sub"]) == (0x2F00, 3)


def test_limits_of_the_file_exclude_values(tmp_path: Path) -> None:
    items = base() | TORQUE | {(0x1016, 1): Item(U32, low=0, high=0xFFFF), (0x6066, 0): Item(U16, high=5)}
    document = proposal(tmp_path, items)
    assert '# accept_missing = ["1016", "6066"]' in document.text
    assert "- 1016:01 watchdog on the master: takes 0 to 65535, 8323322 is needed; " in document.text


def test_rate_units_gear_and_resolution_suit_the_drive_and_the_bus(tmp_path: Path) -> None:
    facts = [facts_of(tmp_path, MADE_UP["one_millisecond"], node) for node in (1, 2, 3)]
    document = propose(facts, BUS)
    assert (document.rig.rate, document.rig.can.max_load) == (1000.0, 0.81)
    assert (document.rig.drives[0].counts_per_turn, document.rig.drives[0].gear) == (360_000, 21.0)
    assert "6092h and 6091h" in document.text
    with pytest.raises(BadInput, match="161% of the bus at 500 kbit/s"):
        propose(facts, BUS.model_copy(update={"bitrate": 500_000}))


def test_other_numbers_of_drives_are_axes(tmp_path: Path) -> None:
    rig = proposal(tmp_path, base() | TORQUE, nodes=(4, 5)).rig
    assert (rig.mechanism, rig.dof, [drive.node_id for drive in rig.drives]) == ("axes", 2, [4, 5])


def test_each_axis_of_a_node_has_its_own_limits(tmp_path: Path) -> None:
    limits = {(0x607D, 1): Item(I32, default=9000), (0x607D, 2): Item(I32, default=-9000)}
    resolution = {(0x608F, 1): Item(U32, default=4000), (0x608F, 2): Item(U32, default=1)}
    facts = facts_of(tmp_path, MadeUpDrive(base() | TORQUE | GEARED | resolution | limits), 5)
    text = propose([facts, replace(facts, node_id=6), replace(facts, axis=2)], BUS).text
    assert text.count("the lower one above the upper one") == 2
    assert "# gravity = true" in propose([facts], BUS).text


def test_a_dcf_is_offered_and_an_eds_says_that_it_only_has_defaults(tmp_path: Path) -> None:
    items = base() | TORQUE
    assert "defaults of this EDS, not settings of your drive" in " ".join(
        proposal(tmp_path, items).text.split("\n# ")
    )
    items[0x6085, 0] = replace(items[0x6085, 0], parameter=5000)
    text = proposal(tmp_path, items).text
    assert "values of this DCF" in " ".join(text.split("\n# "))
    assert "# dcf = " in text


@pytest.mark.parametrize(
    ("without", "modes", "reason"),
    [
        ((), 0x25, "6502h = 25h: neither mode 8"),
        ((0x607A,), 0x80, "607A:00 target position: no such object"),
        ((0x607A, 0x60C1), 0xC0, "607A:00 .* no such object; 60C1:01 .* no such object"),
        ((0x6040,), 0xC0, "no controlword"),
    ],
)
def test_drives_that_cannot_follow_are_refused(
    without: tuple[int, ...], modes: int, reason: str, tmp_path: Path
) -> None:
    items = {a: item for a, item in (base(modes) | TORQUE).items() if a[0] not in without}
    with pytest.raises(BadInput, match=reason):
        proposal(tmp_path, items)


@settings(max_examples=30)
@given(made_up_drives())
def test_any_drive_gets_a_valid_rig_file_or_a_reason(
    tmp_path_factory: pytest.TempPathFactory, made_up: MadeUpDrive
) -> None:
    folder = tmp_path_factory.mktemp("any")
    modes = made_up.items.get((0x6502, 0))
    cannot_follow = modes is not None and modes.default == 0x25
    with pytest.raises(BadInput, match="neither mode 8") if cannot_follow else suppress(BadInput):
        document = propose([facts_of(folder, made_up, node) for node in (1, 2, 3)], BUS)
        assert max(map(len, document.text.splitlines())) <= 130
        assert tomllib.loads(document.text)["drives"][0]["node_id"] == 1
