"""Angles that the robot cannot reach: in degrees, or those of motors before their gears.

What they are to be divided by is what makes the mechanism explain the torque best: gravity and the coupling of joints
depend on the angles themselves, not only on their changes.
"""

from dataclasses import replace

import numpy as np

from ident.basics import slicing
from ident.data.prepared_recording import prepare
from ident.data_problems.arrangement import BAD, MAX_OTHER, error_of
from recordings.command_line import repeated
from recordings.data_problems import DataProblem, healing_command
from recordings.data_problems.signals import MAX_SPAN, travel
from recordings.recording import Floats, Recording
from recordings.rig import Rig
from recordings.urdf_joints import read_joints

KINDS = ("angle-unit", "gear-ratio")
_BEYOND = 2.0
"""Travel, as a multiple of what the declared limits allow, that no limit stated too narrowly explains; it has to be a
whole turn, too, which limits that stand there for form's sake do not allow either."""
_DEGREES = 180 / np.pi
_LARGEST, _SCALES = 500.0, 40
"""No gear of a robot's joint is larger; so many scales are tried up to it."""
_AROUND = (-0.4, 0.4)
"""Natural logarithm of the scales about the best one that are looked at more closely."""
_AS_GOOD = 1.5
"""The error of a scale that may be the true one, as a multiple of the least: a missing effect shifts the best one."""
_MOST_LIKELY = 1.2
"""Degrees are more common than gears of nearly that ratio: they are named up to this multiple of the least error."""
_TOLD = 2.0
"""Ratio of the largest to the least scale that agrees, up to which the torque tells degrees."""
_MODEL_ERROR = 0.005
"""Addition to the least error, as a share of the torque: no model is exact."""
_IMPOSSIBLE = 1e3
"""The error of a scale at which the mechanism cannot be assembled."""
_ROUGH = 0.01
"""Relative accuracy of the scales of single joints."""
_EXCERPT = 12.5
"""Seconds of the motion that are looked at."""

_WHERE = "(daq import --map, in Python map)"


def find(recording: Recording) -> DataProblem | None:
    """Return the problem if a joint travels further than the mechanism or the URDF allows."""
    allowed = [_allowed(recording.rig, joint) for joint in range(recording.rig.dof)]
    travelled = [travel(column) for column in recording.position.T]
    excess = np.array(travelled) / allowed
    worst = int(np.argmax(excess))
    if excess[worst] <= 1 or (recording.rig.mechanism == "urdf" and travelled[worst] <= 2 * np.pi):
        return None
    wide = f"Joint {worst + 1} travels {travelled[worst]:.3g} rad, further than it can"
    if excess[worst] > _LARGEST:
        why = f"{wide}, by more than any gear has: they may be counts of an encoder."
        return _problem("angle-unit", why, f"State their unit, as position_1=position_1:counts/8192 {_WHERE}.")
    excerpt = _excerpt(recording)
    scale, low, high, error = _scales(excerpt, excess[worst])
    gears, apart = _of_each_joint(excerpt, scale)
    if min(error, apart) > BAD:
        why = f"{wide}, and divided by no numbers do the angles agree with the torque: more is wrong."
        return _problem("gear-ratio", why, _stated(50))
    if apart < MAX_OTHER * error:
        ratios = ", ".join(f"{gear:.3g}" for gear in gears)
        why = f"{wide}; divided by about {ratios}, the angles agree with the torque: those of motors before gears."
        return _problem("gear-ratio", why, _stated(round(gears[0])))
    span = f"{low:.3g} to {high:.3g}" if high < _LARGEST else f"{low:.3g} or more"
    agree = f"{wide}; divided by {span}, the angles agree with the torque: they are"
    gear = round(scale)
    if low <= _DEGREES <= high and _error(excerpt, _DEGREES) <= _MOST_LIKELY * error + _MODEL_ERROR:
        told = high < _TOLD * low
        why = (
            f"{agree} in degrees (57.3 to a radian), {'unless a gear has' if told else 'or gears have'} such a ratio."
        )
        return _problem("angle-unit", why, _healed(recording, "deg") if told else _stated(gear))
    unless = ", unless they are in degrees (57.3 to a radian)" if low <= _DEGREES <= high else ""
    alone = gear - 1 < low <= gear <= high < gear + 1
    why = f"{agree} those of motors before gears of such a ratio{unless}."
    return _problem("gear-ratio", why, _healed(recording, f"rad/{gear}") if alone and not unless else _stated(gear))


def _stated(gear: int) -> str:
    return (
        f"State the unit of each joint, as position_1=position_1:rad/{gear} for a gear of {gear}, or "
        f"position_1=position_1:deg for degrees {_WHERE}."
    )


def _problem(kind: str, why: str, remedy: str) -> DataProblem:
    return DataProblem(kind=kind, joints=(), blocks=True, why=why, remedy=remedy)


def _healed(recording: Recording, unit: str) -> str:
    """The command that reads the angles of all joints in `unit`."""
    turning = [joint for joint, kind in enumerate(recording.rig.joint_types, 1) if kind == "revolute"]
    entries = [f"position_{joint}=position_{joint}:{unit}" for joint in turning]
    return healing_command(recording.path, repeated("--map", entries))


def _allowed(rig: Rig, joint: int) -> float:
    """Travel [rad] beyond which the position of a `joint`, from 0, is not its own; infinity where nothing tells."""
    if rig.mechanism == "delta":
        return MAX_SPAN
    if rig.mechanism == "axes" or rig.joint_types[joint] != "revolute":
        return np.inf
    limits = {each.name: each.limits for each in read_joints(rig.urdf)}[rig.joints[joint]]
    return _BEYOND * (limits[1] - limits[0]) if limits else np.inf


def _excerpt(recording: Recording) -> Recording:
    """Rows around the middle of a long recording."""
    middle = (recording.time[0] + recording.time[-1]) / 2
    return slicing.along_time(recording, np.abs(recording.time - middle) <= _EXCERPT / 2)


def _scales(recording: Recording, least: float) -> tuple[float, float, float, float]:
    """The best scale, the least and the largest that explain the torque nearly as well, and the error of the best.

    The error is a share of the torque. least: scale below which joints would travel too far.
    """
    from scipy.optimize import minimize_scalar

    errors = {scale: _error(recording, scale) for scale in np.geomspace(least, _LARGEST, _SCALES)}
    best = min(errors, key=lambda scale: errors[scale])
    found = minimize_scalar(lambda x: _error(recording, best * np.exp(x)), bounds=_AROUND, method="bounded")
    for scale in best * np.exp([found.x, *np.linspace(*_AROUND, 25)]):
        errors[scale] = _error(recording, scale)
    best = min(errors, key=lambda scale: errors[scale])
    error = errors[best]
    good = [scale for scale, other in errors.items() if other <= _AS_GOOD * error + _MODEL_ERROR and scale >= least]
    return best, min(good), max(good), error


def _of_each_joint(recording: Recording, scale: float) -> tuple[Floats, float]:
    """Scales (dof,) of the joints that explain the torque best, from a common `scale`, and their error."""
    from scipy.optimize import minimize

    start = np.full(recording.rig.dof, np.log(scale))

    def error(x: Floats) -> float:
        return _error(recording, np.exp(x))

    found = minimize(error, start, method="Powell", tol=_ROUGH)
    return np.exp(found.x), float(found.fun)


def _error(recording: Recording, scale: Floats | float) -> float:
    """RMS error of the mechanism, as a share of the torque, with positions divided by `scale`, () or (dof,)."""
    turning = np.array(recording.rig.joint_types) == "revolute"
    divided = replace(recording, position=recording.position / np.where(turning, scale, 1.0))
    return min(error_of(prepare(each, "parallel", None) for each in (divided,)), _IMPOSSIBLE)
