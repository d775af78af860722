"""Error of the torque gain in the rig file."""

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from recordings.recording import Floats


def report(torque: Floats, inputs: EffectInputs, values: Values) -> Floats:
    """Divide the torque (n, dof) by 1 + e: the map of the rig file knows nothing of e."""
    return torque / (1 + values["e"])


effect = Signal(
    sentence="One motor gives more or less torque per volt than the rig file says.",
    size="{e:%}",
    symptom="The residual of one joint follows the torque of that joint, standing or moving.",
    causes="a weak magnet, another motor type, a wrong scale of the voltage or current, a gear with another ratio",
    remedy="calibrate the gain of each joint (ident calibrate-gain) and write it into the rig file",
    record="the same motion with and without a known payload",
    equation="torque = (1 + e) gain v |v|",
    axis="load",
    parameters=(
        Quantity(
            name="e",
            unit="1",
            meaning="relative excess of the gain",
            lower=-0.7,
            upper=2.0,
            initial_guesses=(0.02, -0.02),
        ),
    ),
    differential=True,
    report=report,
    unobservable=lambda rig, torque_measured: "it takes a voltage to see a map" if torque_measured else None,
)
