"""What the C code of an arm (`templates/arm_links.c`) needs: its chain, and its identified parameters."""

from collections.abc import Collection, Iterator
from typing import Any

import numpy as np

from ident.dynamics.mechanisms.urdf import motor_matrix
from ident.dynamics.rigid_chain import LINK_PARAMETERS, joint_axis
from ident.export.arms.bodies import base_values, tree_of
from ident.identification.model import Model
from recordings.recording import Floats

_TOOL, _TILT = "payload_change", "base_tilt"
"""Effects that need the torque of a mass at the tool, and that of gravity from the side."""


def chain_of(model: Model, carried: Collection[str]) -> dict[str, Any]:
    """Tables of whole numbers, and what the effects `carried` need of the links."""
    mechanism = tree_of(model)
    links, names = mechanism.links, {name.partition("#")[0] for name in carried}
    joints = np.argsort(links.order)
    kinds = [int(mechanism.chain.types[joint] == "prismatic") for joint in joints]
    return {
        "parents": ", ".join(str(number - 1) for number in list(links.model.parents)[1:]),
        "joints": ", ".join(str(joint) for joint in joints),
        "prismatic": ", ".join(str(kind) for kind in kinds),
        "of_tool": _TOOL in names,
        "of_tilt": _TILT in names,
    }


def constants(model: Model, carried: Collection[str]) -> Iterator[tuple[str, Floats]]:
    """Yield the arrays by name, the links' in the order of Pinocchio's joints."""
    mechanism = tree_of(model)
    links, dof = mechanism.links, len(model.file.joints)
    values, numbers = base_values(model), range(1, links.model.njoints)
    base, count = len(mechanism.base.columns), dof * len(LINK_PARAMETERS)
    physical = np.zeros(mechanism.base.combination.shape[1])
    physical[mechanism.base.columns] = values[:base]
    viscous, coulomb, offset = np.split(values[base:], 3)
    motors = np.zeros(dof)
    motors[: len(physical) - count] = physical[count:]
    order = np.argsort(links.order)
    chain = chain_of(model, carried)
    yield from (("viscous", viscous), ("coulomb", coulomb), ("offset", offset), ("motors", motors))
    yield "coupled", motor_matrix(mechanism.chain)
    yield "gravity", np.array(mechanism.chain.gravity)
    yield "axes", np.array([joint_axis(links, number) for number in numbers])
    yield "rotations", np.array([links.model.jointPlacements[number].rotation for number in numbers])
    yield "places", np.array([links.model.jointPlacements[number].translation for number in numbers])
    yield "inertial", physical[:count].reshape(dof, -1)[order]
    if chain["of_tool"]:
        payload = mechanism.chain.payload
        tool = links.mass_at(payload.place if payload else (0.0, 0.0, 0.0))
        yield "tool", tool.reshape(dof, -1)[order]
    if chain["of_tilt"]:
        yield "across", mechanism.across
        yield "weight", mechanism.physical_parameters(values)[:count].reshape(dof, -1)[order]
