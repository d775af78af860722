"""Back-EMF of the motor in the reported voltage."""

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from ident.dynamics.torque_map import torque_from_voltage, voltage_from_torque
from recordings.recording import Floats
from recordings.rig import Rig


def report(torque: Floats, inputs: EffectInputs, values: Values) -> Floats:
    """Add k_e v to the voltage that gives the torque (n, dof)."""
    voltage = voltage_from_torque(torque, inputs.rig.torque) + values["k_e"] * inputs.motion.velocity
    return torque_from_voltage(voltage, inputs.rig.torque)


def unobservable(rig: Rig, torque_measured: bool) -> str | None:
    """With a linear torque map, back-EMF is indistinguishable from viscous friction."""
    if torque_measured:
        return "The torque itself, or the motor's current, was recorded, and no voltage."
    return "With a linear torque map it is the same as viscous friction." if rig.torque.map == "linear" else None


effect = Signal(
    sentence="The reported voltage contains what the turning motor makes itself.",
    size="{k_e}",
    symptom="The residual grows with speed, the more the harder the joint works at the time.",
    causes="an amplifier that reports the voltage at its terminals, not that which drives the current",
    remedy="record the current or the commanded torque, or take k_e from the motor's data sheet",
    record="high speed at high and at low torque: strokes with and without a load",
    equation="v = map^-1(torque) + k_e velocity",
    axis="velocity",
    parameters=(
        Quantity(
            name="k_e",
            unit="V s/{position}",
            meaning="voltage per speed",
            lower=0.0,
            upper=5.0,
            initial_guesses=(0.01,),
        ),
    ),
    report=report,
    unobservable=unobservable,
)
