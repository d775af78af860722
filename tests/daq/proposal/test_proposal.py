"""Rig files proposed from EDS and DCF files: what they say, and what they leave to the user."""

import tomllib
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings

from daq.proposal.choices import common_torque_source, motor_voltage, torque_sources
from daq.proposal.document import RigProposal, propose
from daq.proposal.facts import DriveFacts, from_file
from recordings.buses import CanBus
from recordings.errors import BadInput
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


def test_ratings_become_the_torque_at_the_joint(tmp_path: Path) -> None:
    drive = proposal(tmp_path, base() | TORQUE).rig.drives[0]
    assert (drive.torque_source, drive.rated_torque) == ("torque_actual", pytest.approx(RATED_TORQUE / 1000 * 21))


def test_a_current_needs_the_torque_constant(tmp_path: Path) -> None:
    stated = proposal(tmp_path, base() | CURRENT | {(0x6076, 0): TORQUE[0x6076, 0]})
    assert stated.rig.torque.per_ampere == pytest.approx((952 / 4200 * 21,) * 3, rel=1e-5)
    assert "6076h / 6075h * gear" in stated.text
    silent = proposal(tmp_path, base() | CURRENT)
    assert silent.rig.drives[0].rated_current == pytest.approx(4.2)
    assert "CHECK: torque constant [N m/A] * gear" in silent.text


@pytest.mark.parametrize(
    ("name", "scale"),
    [
        ("Motor voltage [mV]", 0.001),
        ("output voltage in 0.1 V", 0.1),
        ("Terminal voltage", None),
        ("DC bus voltage", ...),
        ("Motor over-voltage threshold", ...),
        ("motor current", ...),
    ],
)
def test_the_motor_voltage_is_found_by_its_name(name: str, scale: object, tmp_path: Path) -> None:
    items = base() | {(0x2100, 0): Item(I32, "ro", mappable=scale is None, name=name)}
    voltage = motor_voltage(facts_of(tmp_path, MadeUpDrive(items)))
    assert (... if voltage is None else voltage.scale) == scale
    if voltage is not None:  # one that cannot be mapped is polled
        drive = proposal(tmp_path, items).rig.drives[0]
        assert drive.voltage.transfer == ("pdo" if scale is None else "sdo")


def test_known_gains_come_first(tmp_path: Path) -> None:
    unrated = {(0x6077, 0): TORQUE[0x6077, 0]}
    facts = [facts_of(tmp_path, MadeUpDrive(base() | items)) for items in (TORQUE, unrated | CURRENT)]
    assert torque_sources(facts[1]) == ["torque_actual", "current_actual"]
    assert common_torque_source(facts) == "torque_actual"
    assert common_torque_source([facts[0], facts_of(tmp_path, MadeUpDrive(base()))]) is None
    assert any("nothing to find the torque from" in note for note in proposal(tmp_path, base()).notes)


def test_what_needs_a_decision_is_commented_out(tmp_path: Path) -> None:
    items = {a: item for a, item in (base() | TORQUE).items() if a[0] not in (0x1016, 0x6502, 0x6007)}
    text = proposal(tmp_path, items).text
    assert '# accept_missing = ["1016", "6007"]' in text
    assert "- 1016h watchdog on the master: the drive does not stop when this program or the cable fails" in text
    assert "# assume_mode = true" in text
    assert '# units = { acceleration = "counts/s^2" }' in text
    drive = tomllib.loads(text)["drives"][0]
    assert not {"accept_missing", "assume_mode", "units"} & set(drive)


def test_limits_of_the_file_exclude_values(tmp_path: Path) -> None:
    items = base() | TORQUE | {(0x1016, 1): Item(U32, low=0, high=0xFFFF), (0x6066, 0): Item(U16, high=5)}
    document = proposal(tmp_path, items)
    assert '# accept_missing = ["1016", "6066"]' in document.text
    assert any("1016:01 accepts 0...65535 in this file, 8323322 will be written" in note for note in document.notes)


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


def test_a_dcf_is_offered_and_an_eds_says_that_it_only_has_defaults(tmp_path: Path) -> None:
    items = base() | TORQUE
    assert "defaults of this EDS, not settings of your drive" in " ".join(
        proposal(tmp_path, items).text.split("\n# ")
    )
    items[0x6085, 0] = replace(items[0x6085, 0], parameter=5000)
    text = proposal(tmp_path, items).text
    assert "values of this DCF" in text
    assert "# dcf = " in text


@pytest.mark.parametrize(
    ("without", "modes", "reason"),
    [
        ((), 0x25, "6502h = 25h: neither mode 8"),
        ((0x607A,), 0x80, "607Ah cannot be mapped"),
        ((0x607A, 0x60C1), 0xC0, "607Ah and 60C1h:01 cannot be mapped"),
        ((0x6040,), 0xC0, "no controlword"),
    ],
)
def test_drives_that_cannot_follow_are_refused(
    without: tuple[int, ...], modes: int, reason: str, tmp_path: Path
) -> None:
    items = {a: item for a, item in base(modes).items() if a[0] not in without}
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
