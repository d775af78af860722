"""The C code of a model: what the templates in `templates/` need, from the model and the C code of its effects."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import jinja2
import numpy as np

from ident.dynamics.delta_motion import delta_motion, load_torques
from ident.dynamics.effects.base import Additive, Effect, Signal
from ident.dynamics.effects.c_code import CCode
from ident.dynamics.effects.formula import OF_JOINT, C, Formula, Symbol, c_statements, traced
from ident.dynamics.effects.reading import ITERATIONS, MIN_SLOPE, derivatives
from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.dynamics.structure import Term
from ident.identification.model import Model
from recordings.recording import Floats
from trajectories.closed_chain import dots
from trajectories.kinematics import GRAVITY

Real = Literal["double", "float"]
FILES = ("delta_model.h", "delta_model.c", "example.c")
GUID = "{guid}"
"""Stands in the wrapper of an FMU for the digest of all files."""
TEMPERATURE = 40.0
"""Of the drives in the test vectors of a model that depends on it [degC]."""
TOLERANCE = {"double": 1e-9, "float": 1e-3}
"""Largest difference that the example accepts, of the largest torque."""

_OF_JOINT = ("q", "qd", "qdd", "direction", "rigid", "load", "torque_per_mass", "rods")
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


def files(model: Model, carried: frozenset[int], real: Real, more: Sequence[str] = ()) -> dict[str, str]:
    """Text of delta_model.h, delta_model.c and example.c by name, and of `more` templates.

    carried: indices of the terms that are in it.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,  # C, no HTML
    )
    context = _context(model, carried, real)
    return {name: environment.get_template(name).render(context) for name in (*FILES, *more)}


def needs_temperature(model: Model) -> bool:
    """Whether an effect of the model needs the temperature of the drives."""
    return any("temperature" in term.effect.needs for term in model.dynamics.structure.terms)


def why_not(dynamics: InverseDynamics, index: int) -> str | None:
    """Return why the term `index` cannot be stepped in C, or None."""
    code = code_of(dynamics.structure.terms[index].effect)
    if code is None:
        return "no code in C"
    return code.impossible(dynamics.structure.shapes_by_name(index, dynamics.values))


def code_of(effect: Effect) -> CCode | None:
    """The `effect` as C: its own code, or what follows from its formula; None if no controller can step it."""
    code = effect.c or CCode()
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


def _context(model: Model, carried: frozenset[int], real: Real) -> dict[str, Any]:
    dynamics = model.dynamics
    terms = [(index, term) for index, term in enumerate(dynamics.structure.terms) if index in carried]
    functions, states, constants = [], [], list(_mechanism_constants(model, carried))
    for index, term in terms:
        code = code_of(term.effect)
        assert code is not None
        if not term.effect.linear and not code.statements:
            continue  # it changes the constants of the mechanism
        name = dynamics.structure.term_names[index].replace("#", "_")
        arrays = _effect_constants(dynamics, index, code)
        constants += [(f"{name}_{key}", values) for key, values in arrays.items()]
        states += [f"{name}_{key}" for key in code.state]
        functions.append(_function(name, term, code, tuple(arrays)))
    return {
        "about": f"a model of the mechanism '{model.file.mechanism}'",
        "delta": model.file.mechanism == "delta",
        "dof": len(model.file.joints),
        "real": real,
        "guid": GUID,
        "states": states,
        "constants": [(name, ", ".join(_literal(x, real) for x in values.ravel())) for name, values in constants],
        "effects": functions,
        "platform": _platform_statements(),
        "square_map": model.file.torque.map == "square",
        "needs_temperature": needs_temperature(model),
        "temperature": _literal(TEMPERATURE, real),
        "tolerance": TOLERANCE[real],
    }


def _platform_statements() -> list[str]:
    """Statements that compute what effects and masses need of a delta robot's platform."""
    q, v, a, cosines, sines = map(_entries, ("m->q", "m->qd", "m->qdd", "cosines", "sines"))
    velocity, J, tangents, lift, lifts = delta_motion(_entries("lengths", 4), cosines, sines, q, v, a)
    of_rods = load_torques((0, 0, 0), 1, 1, J, tangents, lift, lifts)
    vectors = {"velocity": velocity, "torque_per_mass": dots((lift, lift, lift), J), "rods": of_rods}
    vectors |= {f"J[{limb}]": column for limb, column in enumerate(J)}
    return c_statements({f"m->{name}[{d}]": x for name, vector in vectors.items() for d, x in enumerate(vector)})


def _entries(name: str, count: int = 3) -> tuple[Symbol, ...]:
    return tuple(Symbol("name", f"{name}[{index}]") for index in range(count))


def _mechanism_constants(model: Model, carried: frozenset[int]) -> Iterator[tuple[str, Floats]]:
    """Arrays of the mechanism, with the geometry as the carried effects correct it."""
    structure, values = model.dynamics.structure, model.dynamics.values
    dof, parameters = len(model.file.joints), structure.mechanism_values(values[structure.linear])
    named = dict(zip((parameter.name for parameter in structure.mechanism.parameters), parameters, strict=True))
    numbers = range(1, dof + 1)

    def by_joint(*names: str) -> Floats:
        return np.array([next((named[f"{x}{j}"] for x in names if f"{x}{j}" in named), 0.0) for j in numbers])

    yield "gain", np.broadcast_to(np.array(model.file.torque.gain), (dof,))
    yield "viscous", by_joint("c_v")
    yield "coulomb", by_joint("c_c")
    yield "inertia", by_joint("I_", "m_")
    if model.file.mechanism != "delta":
        yield from (
            (name, by_joint(key)) for name, key in (("weight_cos", "G_c"), ("weight_sin", "G_s"), ("weight", "G_"))
        )
        return
    rig, _ = structure.corrections(values)
    geometry, phi = rig.geometry, np.array(rig.geometry.phi)
    m_d = structure.rigid_parameters(values)[len(parameters) :].sum()
    yield "masses", np.array([named["m_p"], named["T_g"], m_d])
    yield "lengths", np.array([geometry.L1, geometry.L2, geometry.R - geometry.r, -GRAVITY[2]])
    yield "cosines", np.cos(phi)
    yield "sines", np.sin(phi)


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


def _literal(x: float, real: Real) -> str:
    text = repr(float(x))
    return f"{text}f" if real == "float" else text
