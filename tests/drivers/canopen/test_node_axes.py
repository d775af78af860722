"""One node with several axes, driver and simulated node together: each axis moves, stops and is named by itself."""

from pathlib import Path

import numpy as np
import pytest

from daq.proposal.facts import from_file
from drivers.canopen import dcf
from drivers.canopen.drive import CanopenDrives
from drivers.canopen.pdo import bus_load
from drivers.protocol import Goal, Power
from drivers.simulated.mark import EDS
from recordings.errors import BadInput
from recordings.rig import Axis, Drive, Rig, Torque
from tests.conftest import Runner
from tests.drivers.canopen.lossy_bus import LossyBus, reach
from tests.drivers.canopen.made_up_runs import bus_of
from tests.drivers.canopen.made_up_runs import rig_of as rig_for
from tests.drivers.simulated.dictionaries import TORQUE, U16, U32, Item, Items, MadeUpDrive, base, pdo


def rig_of(*places: tuple[int, int], **keys: object) -> Rig:
    """Axes of nodes, (node id, axis) each, with the torque in their TPDO."""
    drives = tuple(
        Drive.model_validate({"node_id": node, "axis": axis, "torque_source": "torque_actual", **keys})
        for node, axis in places
    )
    axes, gain = (Axis(),) * len(drives), (1.0,) * len(drives)
    return Rig(name="axes", mechanism="axes", axes=axes, drives=drives, torque=Torque(gain=gain))


TWO = rig_of((5, 1), (5, 2), (6, 1))


def moving(bus: LossyBus) -> CanopenDrives:
    """The drives while each follows another ramp."""
    driver = bus.driver()
    assert [identity.address for identity in driver.discover()] == ["node 5", "node 5 axis 2", "node 6"]
    driver.configure()
    reach(driver, Goal.ENABLED, Power.ON)
    ramps = np.minimum(np.arange(60) / 50, 1.0)[:, None] * (0.02, -0.04, 0.06)
    for setpoint in driver.encode(ramps):
        assert driver.exchange(setpoint, 0.01).trouble is None
    assert [drive.generator.position for drive in bus.drives] == pytest.approx([0.02, -0.04, 0.06], abs=1e-4)
    return driver


def test_each_axis_is_set_up_at_its_own_objects_and_follows_its_own_targets() -> None:
    bus, requested = LossyBus(TWO), set[tuple[int, int]]()
    bus.witness = lambda cob_id, data: requested.add((cob_id, int.from_bytes(data[1:3], "little")))
    sample = moving(bus).exchange(None, 0.01)
    assert sample.position == pytest.approx((0.02, -0.04, 0.06), abs=1e-3)
    assert {(0x605, 0x6065), (0x605, 0x6865), (0x605, 0x1A40), (0x606, 0x6065)} <= requested
    assert not {(0x606, 0x6865), (0x606, 0x1A40)} & requested


def test_a_fault_of_one_axis_is_named_and_the_others_stop() -> None:
    bus = LossyBus(TWO)
    driver = moving(bus)
    bus.drives[1].fail(0x2310)
    assert "joint 2 (node 5 axis 2): drive fault, continuous over-current" in str(driver.exchange(None, 0.01).trouble)
    reach_off(driver)
    assert not any(drive.powered for drive in bus.drives)


def reach_off(driver: CanopenDrives) -> None:
    """Stop the drives, and switch them off by SDO."""
    driver.goal = Goal.STOPPED
    for _ in range(100):
        driver.exchange(None, 0.01)
    driver.close()


def test_every_axis_of_a_node_stops_without_its_master() -> None:
    bus = LossyBus(TWO)
    moving(bus)
    bus.pulled = True
    bus.wait(1.0)
    assert not any(drive.powered for drive in bus.drives)


@pytest.mark.parametrize(("places", "fits"), [([1, 2, 3, 4], True), ([1, 3], False)])
def test_axes_share_the_cob_ids_of_their_node(places: list[int], fits: bool) -> None:
    """A torque beside the voltage takes a second TPDO, which axis 3 needs for its first one."""
    keys = {} if fits else {"torque_source": "voltage", "torque_actual": True}
    rig = rig_of(*((5, axis) for axis in places), **keys)
    if fits:
        assert bus_load(rig, 500.0) == pytest.approx(bus_load(rig_of(*((n, 1) for n in places)), 500.0))
    else:
        with pytest.raises(BadInput, match="COB-ID 285h is needed by two axes"):
            bus_load(rig, 500.0)


def test_an_axis_that_a_node_does_not_have_is_refused() -> None:
    bus = LossyBus(rig_of((5, 1)))
    bus._rig = rig_of((5, 2))
    driver = bus.driver()
    driver.discover()
    with pytest.raises(BadInput, match=r"node 5 axis 2\): 6040:00 controlword: no such object"):
        driver.configure()


@pytest.mark.parametrize(("further", "own"), [({}, True), ({(0x6840, 0): Item(U16)}, False)])
@pytest.mark.parametrize("refused", [[], ["1840:01"]])
def test_pdos_above_64_are_switched_off_whether_of_this_axis_or_of_one_that_the_rig_does_not_have(
    further: Items, own: bool, refused: list[str], tmp_path: Path
) -> None:
    spare = {(0x1800 + n, 1): Item(U32, default=0x8000_0000) for n in range(2, 64)}
    foreign = pdo(64, False, [0x6041_00_10]) | {(0x1840, 1): Item(U32, default=0x3F1, parameter=0x3F1)}
    made_up = MadeUpDrive({**base(), **TORQUE, **spare, **foreign, **further}, {"refuse_write": refused})
    rig = rig_for(made_up)
    bus = bus_of(made_up, rig)
    written, reports = list[bytes](), list[str]()
    bus.witness = lambda cob_id, data: written.append(data) if cob_id == 0x601 else None
    driver = bus.driver(lambda *report: reports.append(report[-1]))
    driver.discover()
    driver.configure()
    driver.close()
    assert bytes.fromhex("23 40 18 01 F1 03 00 80") in written
    assert any("counted in the bus load" in text for text in reports) == bool(refused)
    path = made_up.write(tmp_path)[0]
    indices = [write.index for write in dcf.configuration(Drive(node_id=1, dcf=str(path)))]
    assert indices == ([0x1840] if own else [])


@pytest.fixture
def two_axes(tmp_path: Path) -> Path:
    """The dictionary of a drive with two axes, each with the objects of CiA 402 that simulated drives have."""
    path, text = tmp_path / "two.dcf", EDS.read_text()
    moved = (f"[{int(part[:4], 16) + 0x800:X}{part[4:]}" for part in text.split("[") if part[:2] in ("60", "65"))
    path.write_text(text + "\n" + "".join(moved))
    return path


def test_a_file_gives_each_axis_its_objects(two_axes: Path) -> None:
    text = two_axes.read_text()
    begin = text.index("[6865]")
    two_axes.write_text(text[:begin] + text[begin:].replace("DefaultValue=", "ParameterValue=77\nDefaultValue=", 1))
    first, second = (dcf.configuration(Drive(node_id=5, axis=axis, dcf=str(two_axes))) for axis in (1, 2))
    assert [(write.index, write.value) for write in second] == [(0x6065, 77)]
    assert first == []


@pytest.mark.parametrize(("name", "of"), [("Safe Torque Off of axis 2", 2), ("STO Axis_1", 1), ("STO", 1)])
def test_an_object_of_a_maker_is_of_the_axis_that_its_name_says(two_axes: Path, name: str, of: int) -> None:
    two_axes.write_text(two_axes.read_text().replace("Motor terminal voltage", name))
    assert [(0x2200, 1) in from_file(two_axes, 5, axis) for axis in (1, 2)] == [of == 1, of == 2]


def test_a_proposal_names_the_axes_and_no_object_of_a_maker_for_further_ones(two_axes: Path) -> None:
    first, second = (from_file(two_axes, 5, axis) for axis in (1, 2))
    assert (0x2200, 1) in first
    assert (0x2200, 1) not in second
    assert (0x6077, 0) in second
    with pytest.raises(BadInput, match="axis 3 of a CiA 402 drive expected, no controlword"):
        from_file(two_axes, 5, 3)


def test_a_rig_file_with_two_axes_of_a_node_is_proposed_checked_and_moved(
    daq_in_process: Runner, two_axes: Path, tmp_path: Path
) -> None:
    proposed = daq_in_process("rig", "propose", "--eds", two_axes, "--nodes", "5,5,6", "--bus", "virtual:two axes")
    assert proposed.code == 0, proposed.err
    text = (tmp_path / "rig.toml").read_text()
    assert "\naxis = 2" in text
    for key, value in {"gear": "21.0", "rated_torque": "20.0", "counts_per_turn": "8192"}.items():
        text = text.replace(f'{key} = "?"', f"{key} = {value}")
    (tmp_path / "rig.toml").write_text(text)
    moved = daq_in_process("jog", "--joint", 2, "--by", 0.02, "--rig", "rig.toml", "--out", "jog.mcap")
    assert moved.code == 0, moved.err
