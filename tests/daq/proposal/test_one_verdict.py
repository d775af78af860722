"""One verdict for every dictionary: what `daq check` or the run refuses, `daq rig propose` has said before."""

import re
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from daq.proposal.document import propose
from daq.proposal.facts import from_file
from drivers.canopen.requirements import ROWS
from recordings.buses import CanBus
from recordings.errors import BadInput
from recordings.rig import load_rig
from tests.drivers.canopen.made_up_runs import Outcome, outcome_of, rig_of
from tests.drivers.simulated.dictionaries import (
    I8,
    I16,
    I32,
    TORQUE,
    U8,
    U16,
    U32,
    Item,
    MadeUpDrive,
    base,
    made_up_drives,
)

BUS = CanBus(interface="virtual", channel="delta")
FEW = settings(max_examples=30, deadline=None, derandomize=True)
MANY = pytest.param(settings(max_examples=200, deadline=None), marks=pytest.mark.slow)
ASKED = {
    "counts_per_turn": "8192",
    "gear": "21.0",
    "rated_torque": "20.0",
    "rated_current": "4.2",
    "per_ampere": "5.0",
    "scale": "0.001",
    "acceleration": '"counts/s^2"',
}
"""What a user puts in place of "?"."""


@dataclass
class Verdicts:
    """What the commands say of one drive."""

    said: str
    """All that `daq rig propose` says, in the file and beside it."""
    outcome: Outcome | None
    """Of check and run with the proposed rig file; None: it proposes none."""


def verdicts(made_up: MadeUpDrive, *, decided: bool = True) -> Verdicts:
    """`decided`: with the lines that need a decision."""
    with tempfile.TemporaryDirectory() as folder:
        path, _ = made_up.write(Path(folder))
        try:
            document = propose([from_file(path, 1)], BUS)
        except BadInput as error:
            return Verdicts(str(error), None)
        rig = Path(folder) / "rig.toml"
        rig.write_text(_filled(document.text, decided=decided))
        outcome = outcome_of(made_up, load_rig(rig))
    comments = re.sub(r"\n# +", " ", document.text)
    return Verdicts("\n".join([comments, *document.notes]), outcome)


def _filled(text: str, *, decided: bool) -> str:
    for key, value in ASKED.items():
        text = re.sub(rf"(?m)(\b{key} = \[?){re.escape(chr(34) + '?' + chr(34))}", rf"\g<1>{value}", text)
    lines = "eds|accept_missing|assume_mode" if decided else "eds"
    return re.sub(rf"(?m)^# ({lines}) =", r"\1 =", text)


def judge(made_up: MadeUpDrive) -> None:
    """Nothing is refused that was not said, neither by the check nor by the run."""
    for decided in (False, True):
        found = verdicts(made_up, decided=decided)
        if found.outcome is None:
            assert _is_refused_later(made_up, found.said), found.said
            continue
        for problem in found.outcome.problems:
            assert _is_said(problem, found.said), f"{problem}\n\n{found.said}"
        assert bool(found.outcome.problems) == bool(found.outcome.refused), found.outcome.refused
        assert not (decided and found.outcome.problems and not _depends(found)), found.outcome.problems


def _is_refused_later(made_up: MadeUpDrive, said: str) -> bool:
    """Whether a rig file that somebody writes for a drive for which none is proposed is refused, too."""
    if "nothing to find the torque from" in said:
        return True  # which is the user's business in a rig file of his own
    with tempfile.TemporaryDirectory() as folder:
        path, _ = made_up.write(Path(folder))
        return bool(outcome_of(made_up, rig_of(made_up, eds=str(path))).problems)


def _is_said(problem: str, said: str) -> bool:
    """Whether a sentence, or that it depends on what is asked, was said."""
    return problem in said or _open_limit(problem) in said


def _open_limit(problem: str) -> str:
    what, _, text = problem.partition(": takes ")
    return f"{what}: takes {text.partition(',')[0]}; whether it takes what the rig file wants depends on"


def _depends(found: Verdicts) -> bool:
    assert found.outcome is not None
    return all(_open_limit(problem) in found.said for problem in found.outcome.problems)


@st.composite
def odd_drives(draw: st.DrawFn) -> MadeUpDrive:
    """Dictionaries with omissions, accesses, limits, sizes, names and places of objects at random."""
    made_up = draw(made_up_drives())
    items = dict(made_up.items)
    # Whether a drive has a mode that it does not name is known when it is written.
    profile = sorted(a for a in items if (a[0] >= 0x6000 and a[0] != 0x6502) or a[0] in (0x1006, 0x1016, 0x1017))
    pdos = sorted(address for address in items if 0x1400 <= address[0] < 0x1C00)
    for address in draw(st.lists(st.sampled_from(profile + pdos[::4]), unique=True, max_size=3)):
        change = draw(st.sampled_from(CHANGES))
        change(items, address)
    return MadeUpDrive(items, {k: v for k, v in made_up.habits.items() if k not in ("allowed", "values")})


Items = dict[tuple[int, int], Item]


def _without(items: Items, address: tuple[int, int]) -> None:
    items.pop(address, None)


def _with(**keys: Any) -> Callable[[Items, tuple[int, int]], None]:
    def change(items: Items, address: tuple[int, int]) -> None:
        if address in items:
            items[address] = replace(items[address], **keys)

    return change


def _unmappable(items: Items, address: tuple[int, int]) -> None:
    """Mapped by no PDO either."""
    _with(mappable=False)(items, address)
    for place, item in items.items():
        if (
            place[0] // 0x200 in (0xB, 0xD)
            and place[1]
            and int(str(item.default)) >> 8 == address[0] << 8 | address[1]
        ):
            items[place] = replace(item, default=0)


def _moved(items: Items, address: tuple[int, int]) -> None:
    """At the other sub-index: one value in place of an array, or an array in place of one value."""
    # A count in place of a deceleration is one by which no drive stops in time, in place of a rating it is one.
    if address in items and not 0x1400 <= address[0] < 0x1C00 and address[0] not in (0x6075, 0x6076, 0x6085):
        item = items.pop(address)
        index, sub = address
        items[index, 0 if sub else 1] = item
        if not sub:
            items |= {(index, 0): Item(U8, "ro", 2), (index, 2): item}


CHANGES = (
    _without,
    _moved,
    _with(access="ro"),
    _with(access="wo"),
    _unmappable,
    _with(low=0, high=0),
    _with(high=1),
    _with(low=3),
    _with(name="Warning distance"),
    _with(name="Speed"),
)


@pytest.mark.parametrize("examples", [FEW, MANY])
def test_what_check_or_run_refuses_was_said(examples: settings) -> None:
    examples(given(odd_drives())(judge))()


AXES_IN_ONE = "is divided into sub-indices: several axes share the objects of one node"
DRIVE = base() | TORQUE | {(0x6091, 1): Item(U32, default=21), (0x6091, 2): Item(U32, default=1)}


def _drive(*absent: int, **further: Item) -> MadeUpDrive:
    """The drive without some objects, and with others, by index and sub-index: `i6063_0`."""
    added = {tuple(int(part, 16) for part in name[1:].split("_")): item for name, item in further.items()}
    return MadeUpDrive({address: item for address, item in DRIVE.items() if address[0] not in absent} | added)


ACTUAL = Item(I16, "ro", mappable=True)


@pytest.mark.parametrize(
    ("made_up", "said"),
    [
        (_drive(0x6064, i6063_0=Item(I32, "ro")), "6064:00 position actual: no such object (6063:00 is there)"),
        (_drive(0x1016, i1016_0=Item(U32)), "1016:01 watchdog on the master: no such object (1016:00 is there)"),
        (_drive(0x6077, i6077_0=Item(U8, "ro", 2), i6077_1=ACTUAL, i6077_2=ACTUAL), f"6077h {AXES_IN_ONE}"),
        (_drive(0x1400, 0x1401, 0x1600, 0x1601), "1 RPDO(s) or more needed for 6040:00, 607A:00, 0 found"),
        (
            _drive(i1400_1=Item(U32, "ro", "$NODEID+0x200"), i1401_1=Item(U32, "ro", "$NODEID+0x300")),
            "1400:01 is read only, so the mapping of its RPDO cannot be changed",
        ),
        (_drive(i1000_0=Item(U32, "ro", 0x191)), "1000:00 device type: profile 401, which is of no drive"),
        (
            _drive(
                i6065_0=Item(U32, name="Tracking warning distance"), i2120_0=Item(U32, name="TrackingErrorDistance")
            ),
            'named "Tracking warning distance 6065" in the dictionary (2120:00 is named "TrackingErrorDistance',
        ),
        (
            _drive(i6085_0=Item(U32, name="Quick stop time [ms]")),
            'named "Quick stop time [ms] 6085" in the dictionary; a quick stop has the deceleration that is set',
        ),
        (
            _drive(i6077_0=replace(ACTUAL, name="Current actual value")),
            'named "Current actual value 6077" in the dictionary, torque actual by',
        ),
        (
            _drive(0x6077, 0x6076, i6078_0=ACTUAL, i6071_0=Item(I16, low=-2048, high=2047)),
            "1000 times what one count of 6078h is; there is no 6075h, and 6071h takes -2048 to 2047",
        ),
    ],
)
def test_what_a_dictionary_lacks_or_says_against_the_standard_is_said(made_up: MadeUpDrive, said: str) -> None:
    assert said in verdicts(made_up).said
    judge(made_up)


def test_values_that_the_dictionary_allows_or_names_are_proposed() -> None:
    only_off, ramp = Item(I16, default=0, low=0, high=0), Item(U32, name="Quick stop deceleration [10 counts/s^2]")
    found = verdicts(_drive(i605E_0=only_off, i6085_0=ramp))
    assert "fault_reaction_option = 0 " in found.said
    assert 'units = { acceleration = "10 counts/s^2" }  # named: "Quick stop deceleration' in found.said
    assert found.outcome is not None
    assert found.outcome.samples


def test_what_is_mapped_by_default_can_be_mapped_whatever_the_file_says() -> None:
    mapped = {"i1A00_0": Item(U8, default=1), "i1A00_1": Item(U32, default=0x6041_00_10)}
    said = "6041:00 statusword: cannot be mapped"
    status = Item(U16, "ro")
    found = verdicts(_drive(i6041_0=status, **mapped)).said
    assert said not in found
    assert "6041:00 statusword: mapped as delivered, though" in found
    assert said in verdicts(_drive(i6041_0=status, i1A00_1=Item(U32), i1A01_1=Item(U32))).said


def test_limits_of_0_and_0_are_none_where_the_defaults_lie_outside() -> None:
    """As some tools write them; the largest of an unsigned type may be -1."""
    none = {"low": 0, "high": 0}
    found = verdicts(_drive(i6060_0=Item(I8, **none), i6065_0=Item(U32, default=2000, **none)))
    assert "takes" not in found.said
    assert found.outcome is not None
    assert found.outcome.samples
    said = verdicts(_drive(i6066_0=Item(U16, low=50, high=-1))).said
    assert "6066:00 following error time-out [ms]: takes 50 to 65535, 10 is needed" in said


def test_what_is_accepted_and_excluded_by_the_file_is_not_written() -> None:
    outcome = verdicts(_drive(i6066_0=Item(U16, default=60, low=50, high=70))).outcome
    assert outcome is not None
    (text,) = outcome.reports
    assert text.startswith("driven without 6066:00 following error time-out [ms]: takes 50 to 70, 10 is needed")


def test_an_electronic_gear_is_no_gear() -> None:
    """6091h = 131072/10000 beside 608Fh = 131072: 10000 position units to a turn of the motor."""
    encoder = {(0x608F, 1): 131_072, (0x608F, 2): 1, (0x6091, 1): 131_072, (0x6091, 2): 10_000}
    made_up = MadeUpDrive(DRIVE | {address: Item(U32, default=value) for address, value in encoder.items()})
    found = verdicts(made_up)
    assert "counts_per_turn = 10000" in found.said
    assert "608Fh and 6091h, read as an electronic gear" in found.said
    assert 'gear is "?"' in found.said
    assert found.outcome is not None
    assert not found.outcome.problems


@pytest.mark.parametrize(
    ("index", "name", "is_other"),
    [
        (0x6065, "Following error window", False),
        (0x6065, "Following error alarm window", False),
        (0x6065, "Max_PositionDeviation", False),
        (0x6065, "Schleppfehlerfenster", False),
        (0x6065, "PositionErrorWarning", True),
        (0x6065, "Speed error window", True),
        (0x6065, "Schleppfehler_Warnschwelle", True),
        (0x6066, "Following error delay", False),
        (0x605E, "Alarm reaction option code", False),
        (0x6064, "Current position", False),
        (0x6077, "Actual motor current", True),
        (0x6078, "Torque current actual", False),
        (0x6085, "Quick stop ramp time", False),
    ],
)
def test_a_name_counts_only_against_the_standard(index: int, name: str, is_other: bool) -> None:
    assert ROWS[index, 0].contradicts(name) == is_other


def test_exchanged_position_limits_do_not_protect() -> None:
    low, high = ROWS[0x607D, 1], ROWS[0x607D, 2]
    for names in (("Min position limit", "Max position limit"), ("Soft_Negative_Limit", "Soft_Positive_Limit")):
        assert [row.contradicts(name) for row in (low, high) for name in names] == [False, True, True, False]


def test_the_rate_suits_the_bit_rate() -> None:
    with tempfile.TemporaryDirectory() as folder:
        path, _ = MadeUpDrive(DRIVE).write(Path(folder))
        drives = [from_file(path, node) for node in (1, 2, 3)]
        rates = {k: propose(drives, CanBus(interface="virtual", bitrate=1000 * k)).rig.rate for k in (1000, 500, 250)}
    assert rates == {1000: 500.0, 500: 250.0, 250: 200.0}


@pytest.mark.parametrize("kind", [1, 255])
def test_a_mapping_that_is_read_only_and_right_is_used(kind: int) -> None:
    fixed = {
        **{"i1400_1": Item(U32, "ro", "$NODEID+0x200"), "i1400_2": Item(U8, default=kind)},
        **{"i1600_0": Item(U8, default=2), "i1600_1": Item(U32, default=0x6040_00_10)},
        **{"i1600_2": Item(U32, default=0x607A_00_20), "i1401_1": Item(U32, "ro", "$NODEID+0x300")},
    }
    found = verdicts(_drive(**fixed))
    assert found.outcome is not None
    assert not found.outcome.problems
    assert found.outcome.samples
