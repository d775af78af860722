"""Units: spellings, factors, and what they are converted to."""

import math

import numpy as np
import pytest

from recordings.importing.units import RigHints, parse, split_header, to_si
from recordings.rig import Drive

DRIVE = Drive(node_id=1, counts_per_turn=1000, gear=10.0, sign=-1, zero_offset=0.5, rated_torque=40.0)


@pytest.mark.parametrize(
    ("text", "quantity", "expected"),
    [
        ("rad", "position", 2.0),
        ("deg", "position", 2 * math.pi / 180),
        ("°", "command", 2 * math.pi / 180),
        ("turns", "position", 4 * math.pi),
        ("counts/8192", "position", 4 * math.pi / 8192),
        ("*0.5", "position", 1.0),
        ("deg*-1", "position", -2 * math.pi / 180),
        ("deg/21", "position", 2 * math.pi / 180 / 21),
        ("rpm", "velocity", 2 * 2 * math.pi / 60),
        ("deg/s", "velocity", 2 * math.pi / 180),
        ("counts/s/8192", "velocity", 4 * math.pi / 8192),
        ("mNm", "effort", 2e-3),
        ("N·m", "effort", 2.0),
        ("A*0.12", "effort", 0.24),
        ("mA*0.12", "effort", 0.24e-3),
        ("%*20", "effort", 0.4),
        ("permille*20", "effort", 0.04),
        ("mA", "current", 2e-3),
        ("K", "temperature", 2 - 273.15),
        ("mV", "voltage", 2e-3),
        (" µm ", "position of a slide", 2e-6),
        ("mm/s", "velocity of a slide", 2e-3),
        ("N", "effort of a slide", 2.0),
        ("counts*1e-6", "position of a slide", 2e-6),
    ],
)
def test_values_in_si(text: str, quantity: str, expected: float) -> None:
    unit = parse(text)
    name, _, slide = quantity.partition(" of a ")
    hints = RigHints(("prismatic",) if slide else ("revolute",))
    np.testing.assert_allclose(to_si(np.array([2.0, np.nan]), unit, name, 0, hints, "here"), [expected, np.nan])


@pytest.mark.parametrize(
    ("text", "quantity", "expected"),
    [
        ("counts", "position", 0.5 - 2 / 10_000 * 2 * math.pi),
        ("inc/s", "velocity", -2 / 10_000 * 2 * math.pi),
        ("%", "effort", 0.8),
    ],
)
def test_drives_of_a_rig_file_say_counts_and_rated_torque(text: str, quantity: str, expected: float) -> None:
    unit = parse(text)
    hints = RigHints(("revolute",), (DRIVE,))
    np.testing.assert_allclose(to_si(np.array([2.0]), unit, quantity, 0, hints, "here"), [expected])


@pytest.mark.parametrize("text", ["", "furlong", "deg*x", "A*0", "deg//2", "s s", "*"])
def test_other_text_is_no_unit(text: str) -> None:
    assert parse(text) is None


@pytest.mark.parametrize(
    ("header", "expected"),
    [
        ("q1 [deg]", ("q1", "deg")),
        ("Time (ms)", ("Time", "ms")),
        ("Iq_[A]", ("Iq", "A")),
        ("axis[1]", ("axis[1]", "")),
        ("GVL.axis[2] [rad]", ("GVL.axis[2]", "rad")),
        ("[deg]", ("[deg]", "")),
        (" plain ", ("plain", "")),
    ],
)
def test_unit_in_brackets_is_split_from_the_name(header: str, expected: tuple[str, str]) -> None:
    assert split_header(header) == expected
