import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.amplifier import Amplifier, torque

torques = st.floats(-50.0, 50.0)


@given(command=torques, gain=st.floats(0.1, 10.0), exponent=st.floats(0.5, 3.0))
def test_reported_voltage_maps_to_the_torque(command: float, gain: float, exponent: float) -> None:
    amplifier = Amplifier(gain=gain, exponent=exponent)
    assert torque(amplifier.voltage(command, 0.0), gain, exponent) == pytest.approx(command, abs=1e-9)
    assert amplifier.torque(command) == pytest.approx(command, abs=1e-9)


def test_back_emf_adds_to_the_voltage() -> None:
    amplifier = Amplifier(gain=1.0, exponent=1.0, back_emf=0.3)
    assert amplifier.voltage(2.0, 4.0) == pytest.approx(3.2)


@given(command=torques)
def test_faults_act_in_their_order_between_command_and_motor(command: float) -> None:
    faults = (lambda volts: volts / 2, lambda volts: volts - 1)
    commanded, measured = (
        Amplifier(gain=1.0, exponent=1.0, faults=faults, reports_command=reports_command)
        for reports_command in (True, False)
    )
    assert commanded.torque(command) == measured.torque(command) == pytest.approx(command / 2 - 1)
    assert commanded.voltage(command, 0.0) == pytest.approx(command)
    assert measured.voltage(command, 0.0) == pytest.approx(command / 2 - 1)
