"""Torque with another sign than the motion."""

from ident.data_problems.facts import Facts
from ident.data_problems.remedies import mapping
from recordings.data_problems import DataProblem, joint_list


def find(facts: Facts) -> DataProblem | None:
    """Return the problem if another sign of the torque of some joints explains the motion far better."""
    found = facts.arrangements.best
    if found is None or found[0].moved:
        return None
    best, present, other = found
    joints = [joint + 1 for joint in best.turned]
    return DataProblem(
        kind="torque-sign",
        joints=tuple(joints),
        blocks=True,
        why=f"The torque of {joint_list(joints)} has the other sign: as it is, {present:.0%} of the torque is left "
        f"unexplained, turned {other:.0%}.",
        remedy=mapping(facts.recordings[0].recording, ("drive",), best),
    )
