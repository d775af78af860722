"""The C code of a model: what the templates in `templates/` need, from the model and the C code of its effects."""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np

from ident.dynamics.delta_motion import ball_torques, delta_motion, load_torques
from ident.dynamics.effects.base import Additive, Effect, Signal
from ident.dynamics.effects.c_code import CCode
from ident.dynamics.effects.formula import OF_JOINT, C, Formula, Symbol, c_statements, traced
from ident.dynamics.effects.reading import ITERATIONS, MIN_SLOPE, derivatives
from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.dynamics.structure import Term
from ident.estimation.settings import Meaning
from ident.export.arms import c_constants
from ident.export.rendering import rendered
from ident.identification.model import Model
from recordings.errors import BadInput
from recordings.recording import Floats
from trajectories.closed_chain import dots
from trajectories.kinematics import GRAVITY

Real = Literal["double", "float"]
FILES = ("delta_model.h", "delta_model.c", "example.c")
GUID = "{guid}"
"""Stands in the wrapper of an FMU for the digest of all files."""
TEMPERATURE = 40.0
"""Of the drives in the test vectors of a model that depends on it [degC]."""
TOLERANCE = {"double": 1e-12, "float": 1e-4}
"""Largest difference that the example accepts, of the largest torque."""

_OF_JOINT = ("q", "qd", "qdd", "direction", "rigid", "load", "torque_per_mass", "rods", "balls_dry", "balls_viscous")
_OF_MOTION = ("t", "dt", "first")
_OF_PLATFORM = ("J", "velocity")
_CONSTANTS = {
    "c_v": "viscous[i]",
    "c_c": "coulomb[i]",
    "m_p": "masses[0]",
    "T_g": "masses[1]",
    "m_d": "masses[2]",
    "L1": "lengths[0]",
    "cos_phi": "cosines[i]",
    "sin_phi": "sines[i]",
}
_DOUBLE = re.compile(
    r"\b(?:a?sinh?|a?cosh?|a?tanh?|atan2|exp2?|expm1|log(?:2|10|1p)?|pow|sqrt|cbrt|hypot|erfc?|fabs|fmin|fmax|fmod|"
    r"floor|ceil|round|trunc|copysign)(?=\()|(?<![\w.])(?:\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)(?![\w.])"
)
"""Functions of <math.h> and numbers of type double."""


@dataclass(frozen=True)
class CSettings:
    """Settings of the C code."""

    prefix: Annotated[str, Meaning("what the names of functions and macros begin with")] = "delta_model"
    smooth_velocity: Annotated[
        float, Meaning("speed [rad/s or m/s] within which tanh stands for the sign of the velocity; 0: the sign")
    ] = 0.0

    def __post_init__(self) -> None:
        if not re.fullmatch(r"[A-Za-z]\w*", self.prefix, re.ASCII):
            raise BadInput(f"prefix: a name of C expected, such as left_arm, '{self.prefix}' found; change it")
        if self.smooth_velocity < 0:
            raise BadInput(
                f"smooth_velocity: a speed of 0 or more expected, {self.smooth_velocity:g} found; change it"
            )

    def direction(self, velocity: Floats) -> Floats:
        """Sign of the `velocity`, smooth if so chosen."""
        return np.tanh(velocity / self.smooth_velocity) if self.smooth_velocity else np.sign(velocity)


@dataclass(frozen=True)
class EffectFunction:
    """One effect as a function of the generated file."""

    name: str
    additive: bool
    on_arm: bool
    """Whether its torque is a part of the load of the gears."""
    state: bool
    """Whether it remembers anything."""
    declarations: tuple[str, ...]
    statements: tuple[str, ...]
    expression: str


def files(
    model: Model,
    carried: Collection[str],
    real: Real,
    settings: CSettings,
    digest: str,
    more: Sequence[str] = (),
    values: Mapping[str, Any] = {},
) -> dict[str, str]:
    """Text of delta_model.h, delta_model.c and example.c by name, and of `more` templates, which use `values`.

    carried: names of the terms that are in it; digest: of the model file.
    """
    context = _context(model, carried, real, settings) | {"digest": digest, **values}
    texts = {name: rendered(name, context) for name in (*FILES, *more)}
    if real == "float":
        texts["delta_model.c"] = _DOUBLE.sub(r"\g<0>f", texts["delta_model.c"])
    renamed = {"delta_model_": f"{settings.prefix}_", "DELTA_MODEL_": f"{settings.prefix.upper()}_"}
    for old, new in renamed.items():
        texts = {name: text.replace(old, new) for name, text in texts.items()}
    return texts


def needs_temperature(model: Model) -> bool:
    """Whether an effect of the model needs the temperature of the drives."""
    return any("temperature" in term.effect.needs for term in model.dynamics.structure.terms)


def why_not(dynamics: InverseDynamics, index: int) -> str | None:
    """Return why the term `index` cannot be stepped in C, or None."""
    code = code_of(dynamics.structure.terms[index].effect, dynamics.structure.rig.mechanism == "urdf")
    if code is None:
        return "no code in C"
    return code.impossible(dynamics.structure.shapes_by_name(index, dynamics.values))


def code_of(effect: Effect, links: bool = False) -> CCode | None:
    """The `effect` as C: its own code, or what follows from its formula; None if no controller can step it.

    links: of a tree of links.
    """
    code = effect.c or CCode()
    if links and code.of_links:
        return replace(code, expression=code.of_links)
    if isinstance(effect, Additive) and effect.formula is not None:
        return replace(code, expression=C(effect.expression))
    if isinstance(effect, Signal) and effect.reading is not None:
        return CCode(statements=_inverse(effect.reading))
    return code if effect.c or effect.corrects_motion else None


def _inverse(reading: Formula) -> str:
    """Statements that make q, qd and qdd of what an encoder reads: `PositionCorrection` in C."""
    expression, slope, bend = (C(each) for each in (*traced(reading), *derivatives(reading)))
    return f"""
        const real measured = q;
        for (int step = 0; step < {ITERATIONS}; step++) {{
            const real error = {expression} - measured, rise = {slope};
            q -= error / fmax(rise, {C(MIN_SLOPE)});
        }}
        const real slope = {slope}, bend = {bend};
        qdd = qdd / slope - bend * qd * qd / (slope * slope * slope);
        qd /= slope;"""


def _context(model: Model, carried: Collection[str], real: Real, settings: CSettings) -> dict[str, Any]:
    dynamics = model.dynamics
    names = dynamics.structure.term_names
    functions, states, constants = [], [], list(_mechanism_constants(model, carried))
    for index, term in enumerate(dynamics.structure.terms):
        if names[index] not in carried:
            continue
        code = code_of(term.effect, model.file.mechanism == "urdf")
        assert code is not None
        if not term.effect.linear and not code.statements:
            continue  # it changes the constants of the mechanism
        name = names[index].replace("#", "_")
        arrays = _effect_constants(dynamics, index, code)
        constants += [(f"{name}_{key}", values) for key, values in arrays.items()]
        states += [f"{name}_{key}" for key in code.state]
        functions.append(_function(name, term, code, tuple(arrays)))
    return {
        "about": f"a model of the mechanism '{model.file.mechanism}'",
        "delta": model.file.mechanism == "delta",
        "links": c_constants.chain_of(model, carried) if model.file.mechanism == "urdf" else None,
        "dof": len(model.file.joints),
        "real": real,
        "guid": GUID,
        "states": states,
        "constants": [(name, ", ".join(repr(float(x)) for x in values.ravel())) for name, values in constants],
        "effects": functions,
        "platform": _platform_statements(any("m->balls" in line for each in functions for line in each.declarations)),
        "square_map": model.file.torque.map == "square",
        "needs_temperature": needs_temperature(model),
        "temperature": TEMPERATURE,
        "tolerance": TOLERANCE[real],
        "smooth_velocity": settings.smooth_velocity,
        "known_range": model.file.motion_range is not None,
    }


def _platform_statements(balls: bool) -> list[str]:
    """Statements that compute what effects and masses need of a delta robot's platform, and of its `balls`."""
    q, v, a, cosines, sines = map(_entries, ("m->q", "m->qd", "m->qdd", "cosines", "sines"))
    velocity, J, tangents, lift, lifts = delta_motion(_entries("lengths", 4), cosines, sines, q, v, a)
    of_rods = load_torques((0, 0, 0), 1, 1, J, tangents, lift, lifts)
    vectors = {"velocity": velocity, "torque_per_mass": dots((lift, lift, lift), J), "rods": of_rods}
    if balls:
        dry, viscous = ball_torques(_entries("lengths"), cosines, sines, q, v)
        vectors |= {"balls_dry": dry, "balls_viscous": viscous}
    vectors |= {f"J[{limb}]": column for limb, column in enumerate(J)}
    return c_statements({f"m->{name}[{d}]": x for name, vector in vectors.items() for d, x in enumerate(vector)})


def _entries(name: str, count: int = 3) -> tuple[Symbol, ...]:
    return tuple(Symbol("name", f"{name}[{index}]") for index in range(count))


def _mechanism_constants(model: Model, carried: Collection[str]) -> Iterator[tuple[str, Floats]]:
    """Arrays of the mechanism, with the geometry as the carried effects correct it."""
    structure, values = model.dynamics.structure, model.dynamics.values
    dof, parameters = len(model.file.joints), structure.mechanism_values(values[structure.linear])
    named = dict(zip((parameter.name for parameter in structure.mechanism.parameters), parameters, strict=True))
    numbers = range(1, dof + 1)

    def by_joint(*names: str) -> Floats:
        return np.array([next((named[f"{x}{j}"] for x in names if f"{x}{j}" in named), 0.0) for j in numbers])

    yield from zip(("least", "most"), _motion_range(model), strict=True)
    yield "gain", np.broadcast_to(np.array(model.file.torque.gain), (dof,))
    if model.file.mechanism == "urdf":
        yield from c_constants.constants(model, carried)
        return
    yield "viscous", by_joint("c_v")
    yield "coulomb", by_joint("c_c")
    yield "inertia", by_joint("I_", "m_")
    if model.file.mechanism != "delta":
        yield from (
            (name, by_joint(key)) for name, key in (("weight_cos", "G_c"), ("weight_sin", "G_s"), ("weight", "G_"))
        )
        return
    rig, _ = structure.corrections(values, structure.rig)
    geometry, phi = rig.geometry, np.array(rig.geometry.phi)
    m_d = structure.rigid_parameters(values)[len(parameters) :].sum()
    yield "masses", np.array([named["m_p"], named["T_g"], m_d])
    yield "lengths", np.array([geometry.L1, geometry.L2, geometry.R - geometry.r, -GRAVITY[2]])
    yield "cosines", np.cos(phi)
    yield "sines", np.sin(phi)


def _motion_range(model: Model) -> tuple[Floats, Floats]:
    """Least and most (3 * dof,) position, velocity and acceleration of the fit; an empty range if not known."""
    motion = model.file.motion_range
    if motion is None:
        nothing = np.ones(3 * len(model.file.joints))
        return nothing, -nothing
    limits = np.array([motion.position, motion.velocity, motion.acceleration])
    return limits[..., 0].ravel(), limits[..., 1].ravel()


def _effect_constants(dynamics: InverseDynamics, index: int, code: CCode) -> dict[str, Floats]:
    """Arrays by name: local parameters and local shapes for every joint, shared shapes, and further constants."""
    structure, term = dynamics.structure, dynamics.structure.terms[index]
    local, dof = structure.local_values(index, dynamics.values), structure.rig.dof
    rows = np.zeros((dof, local.shape[1]))
    rows[list(range(dof)) if term.effect.whole_robot else list(term.joints)] = local
    arrays = {quantity.name: rows[:, k] for k, quantity in enumerate(term.local_parameters)}
    shapes = structure.shapes_by_name(index, dynamics.values)
    if code.constants:
        of_joints = [{name: float(np.broadcast_to(x, dof)[i]) for name, x in shapes.items()} for i in range(dof)]
        made = [code.constants(of_joint, row) for of_joint, row in zip(of_joints, rows, strict=True)]
        arrays = {name: np.stack([each[name] for each in made]) for name in made[0]}
    return {**arrays, **{name: np.atleast_1d(value) for name, value in shapes.items()}}


def _function(name: str, term: Term, code: CCode, arrays: tuple[str, ...]) -> EffectFunction:
    """The effect of `term` as a function; arrays: names of its constants."""
    additive = term.effect.linear
    used = set(re.findall(r"\b[A-Za-z_]\w*\b", code.statements + code.expression))
    declarations = [
        *_effect_values(name, term, code, [key for key in arrays if key in used]),
        *(f"real *{key} = &state->{name}_{key}[i];" for key in code.state),
        *_inputs(used - set(arrays), additive),
    ]
    text, expression = code.statements, code.expression
    for key in _OF_PLATFORM:
        text, expression = (re.sub(rf"\b{key}\[", f"m->{key}[", part) for part in (text, expression))
    lines = [line.strip() for line in text.strip().splitlines()]
    if not any("m->" in line for line in (*declarations, text, expression)):
        declarations.insert(0, "(void)m;")
    if not additive:
        lines += [f"m->{key}[i] = {key};" for key in ("q", "qd", "qdd") if key in used]
    remembers = bool(code.state) or "temperature" in used
    on_arm = isinstance(term.effect, Additive) and term.effect.on_arm
    return EffectFunction(name, additive, on_arm, remembers, tuple(declarations), tuple(_indented(lines)), expression)


def _effect_values(name: str, term: Term, code: CCode, keys: list[str]) -> Iterator[str]:
    """Declarations of an effect's constants: shapes, numbers of the joint, and further arrays as a whole."""
    shapes = {shape.name for shape in term.effect.shapes}
    for key in keys:
        if key in shapes:
            yield f"const real {key} = {name}_{key}[{'i' if term.effect.local_shapes else '0'}];"
        else:
            yield f"const real *{key} = {name}_{key};" if code.constants else f"const real {key} = {name}_{key}[i];"


def _inputs(used: set[str], additive: bool) -> Iterator[str]:
    """Declarations of what the code uses of the motion, the state, and the mechanism."""
    const = "const " if additive else ""
    yield from (f"{const}real {key} = m->{key}[i];" for key in _OF_JOINT if key in used)
    for found in filter(None, map(OF_JOINT.fullmatch, sorted(used))):
        yield f"const real {found[0]} = m->{found[1]}[{int(found[2]) - 1}];"
    for key in _OF_MOTION:
        if key in used:
            yield f"const {'int' if key == 'first' else 'real'} {key} = m->{key};"
    yield from (f"const real {key} = {value};" for key, value in _CONSTANTS.items() if key in used)
    if "temperature" in used:
        yield "const real temperature = state->temperature[i];"


def _indented(lines: list[str]) -> Iterator[str]:
    """Indent the lines between braces."""
    depth = 0
    for line in lines:
        depth -= line.startswith("}")
        yield "    " * depth + line
        depth += line.endswith("{")
