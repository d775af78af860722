import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.amplifier import Amplifier, torque

torques = st.floats(-50.0, 50.0)


@given(wanted=torques, gain=st.floats(0.1, 10.0), exponent=st.floats(0.5, 3.0))
def test_reported_voltage_stands_for_the_torque(wanted: float, gain: float, exponent: float) -> None:
    amplifier = Amplifier(gain=gain, exponent=exponent)
    assert torque(amplifier.voltage(wanted, 0.0), gain, exponent) == pytest.approx(wanted, abs=1e-9)
    assert amplifier.torque(wanted) == pytest.approx(wanted, abs=1e-9)


def test_turning_motor_adds_to_the_voltage() -> None:
    amplifier = Amplifier(gain=1.0, exponent=1.0, back_emf=0.3)
    assert amplifier.voltage(2.0, 4.0) == pytest.approx(3.2)


@given(wanted=torques)
def test_faults_act_in_their_order_between_command_and_motor(wanted: float) -> None:
    faults = (lambda volts: volts / 2, lambda volts: volts - 1)
    commanded, measured = (
        Amplifier(gain=1.0, exponent=1.0, faults=faults, reports_command=command) for command in (True, False)
    )
    assert commanded.torque(wanted) == measured.torque(wanted) == pytest.approx(wanted / 2 - 1)
    assert commanded.voltage(wanted, 0.0) == pytest.approx(wanted)
    assert measured.voltage(wanted, 0.0) == pytest.approx(wanted / 2 - 1)
