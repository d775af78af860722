"""`daq reveal`: the sealed truth of a simulated recording, beside what was found."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from daq.command_options import FILE, JSON
from recordings.command_line import say_next
from recordings.errors import BadInput
from recordings.files import free_name
from recordings.limits import json_object
from recordings.next_command import diagnosis as diagnosis_command

_SEALED = ".sealed.json"
_GRAVITY = 9.81
_SPECIFIED = ("name", "joints", "parameters")
_OF_EVERY_ROBOT = ("rod_inertia",)
"""Effects that every simulated robot has, so that they are not hidden."""

Effects = Mapping[str, tuple[int, ...]]
"""Joints of each effect, from 1."""
Value = tuple[float, Sequence[float] | None]
"""Of a parameter that was found, and its 95 % interval."""
Alternatives = Mapping[str, Sequence[str]] | None
"""Of each effect, those from which the recordings cannot tell it; None: not known, as a model does not hold them."""


@click.command(
    short_help="Open the sealed truth of a simulated recording.",
    epilog="Example: daq reveal runs/fig5a.mcap runs/better.model.json",
)
@click.argument("file", type=FILE)
@click.argument("diagnosis", metavar="[DIAGNOSIS.json]", required=False, type=FILE)
@JSON
def command(file: Path, diagnosis: Path | None, as_json: bool) -> None:
    """Show what was hidden in the simulated robot of the recording FILE.

    With DIAGNOSIS.json, the output of `ident diagnose --json` or a model of `ident diagnose --apply`, shows the truth
    beside what was found.
    """
    from drivers.simulated.seal import sealed_path, unseal

    recording = file.with_name(f"{file.name.removesuffix(_SEALED)}.mcap") if file.name.endswith(_SEALED) else file
    content = unseal(sealed_path(recording))
    diagnosed = _read(diagnosis) if diagnosis else None
    document = _document(content, diagnosed)
    if as_json:
        click.echo(json.dumps(document, indent=2, allow_nan=False))
    else:
        for line in _lines(document):
            click.echo(line)
    if diagnosed is None:
        say_next(*diagnosis_command([recording], model=recording.with_suffix(".model.json")))
    else:
        seed = 0 if content["seed"] is None else content["seed"] + 1
        out = free_name(Path(f"hidden-{seed}.mcap"))
        say_next("daq", "record", "--traj", "fig5a", "--cycles", 2, "--hidden", seed, "--out", out)


def _read(path: Path) -> tuple[Effects, Mapping[str, Value], Alternatives]:
    """Effects, parameters and alternatives of a diagnosis or a model."""
    content = json_object(path, "diagnosis")
    try:
        if "findings" in content:
            parameters = {name: _value(each) for name, each in content["steps"][-1]["parameters"].items()}
            effects = {entry["effect"]: tuple(entry["joints"]) for entry in content["findings"]}
            return effects, parameters, {entry["effect"]: entry["confusable_with"] for entry in content["findings"]}
        entries = [*content["parameters"], *content.get("searched", ())]
        terms = {term["name"]: tuple(term["joints"]) for term in content["terms"]}
        return terms, {entry["name"]: _value(entry) for entry in entries}, None
    except (ValueError, KeyError, TypeError, IndexError, AttributeError):
        raise BadInput(
            f"{path}: the output of `ident diagnose --json`, or a model of `ident diagnose --apply`, expected, "
            "something else found; check the path"
        ) from None


def _value(entry: Mapping[str, Any]) -> Value:
    """Value and interval, as `ident diagnose` shows it: for the torque gain of the rig file."""
    return float(entry["value"]), entry.get("shape_ci95") or entry.get("ci95")


def _document(
    content: Mapping[str, Any], diagnosed: tuple[Effects, Mapping[str, Value], Alternatives] | None
) -> dict[str, Any]:
    hidden = [effect | {"identified": _common(effect, content)} for effect in content["effects"]]
    document: dict[str, Any] = {"schema": 1, "seed": content["seed"], "hidden": hidden, "found": None}
    if diagnosed is None:
        return document
    effects, parameters, alternatives = diagnosed
    names = {effect["name"] for effect in hidden}
    for effect in hidden:
        effect["verdict"] = _verdict(effect, effects, alternatives)
    document["found"] = [
        {"effect": name, "joints": list(joints)} for name, joints in effects.items() if name not in _OF_EVERY_ROBOT
    ]
    document["not_hidden"] = [name for name in effects if name not in names and name not in _OF_EVERY_ROBOT]
    true = dict(_machine(content["plant"])) if "plant" in content else {}
    for effect in hidden:
        true |= _parameters(effect, content, parameters)
    document["parameters"] = {
        name: {"true": true.get(name), "found": value, "ci95": interval}
        for name, (value, interval) in parameters.items()
        if name in true or name.partition(".")[0] in names
    }
    return document


def _verdict(effect: Mapping[str, Any], effects: Effects, alternatives: Alternatives) -> str:
    name = effect["name"]
    if name in effects:
        joints, expected = effects[name], tuple(effect["joints"])
        return "found" if joints == expected or not expected else f"found on joint {_listed(joints)}"
    confused = [other for other, names in (alternatives or {}).items() if name in names]
    if confused:
        return f"found as {confused[0]}, from which these recordings cannot tell it"
    if not effect["in_library"]:
        return "not found: no effect of the library"
    if alternatives is None and any(other not in _OF_EVERY_ROBOT for other in effects):
        return "not in this model; whether another effect stands for it, the output of `ident diagnose --json` says"
    return "not found"


def _identified(
    effect: Mapping[str, Any], content: Mapping[str, Any], found: Mapping[str, float]
) -> Iterator[tuple[str, int, float]]:
    """Yield the values of an effect by the names of `ident effects`, joint by joint; found: what a model has."""
    from drivers.simulated.config import EffectSpec
    from drivers.simulated.effect import build, discover

    friction = content.get("plant", {}).get("friction", {}).get("coulomb", ())
    coulomb = dict(enumerate(friction, start=1))
    specified = EffectSpec.model_validate({key: effect[key] for key in _SPECIFIED}, strict=False)
    for joint in effect["joints"]:
        own = effect["parameters"]
        if effect["name"] in discover():  # the truth of another plant may hold others
            own = build(specified).identified(joint, coulomb.get(joint, math.nan), found)
        yield from ((name, joint, value) for name, value in own.items() if math.isfinite(value))


def _common(effect: Mapping[str, Any], content: Mapping[str, Any]) -> dict[str, float]:
    """Values that all of its joints have, by the names of `ident effects`; of a curve those of its law."""
    values: dict[str, set[float]] = {}
    for name, _, value in _identified(effect, content, {}):
        values.setdefault(name, set()).add(value)
    return {name: value for name, (value, *others) in values.items() if not others} or dict(effect["parameters"])


def _machine(plant: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    """Yield the true parameters of the base model of a delta robot, for the true torque gain."""
    links, friction = plant["links"], plant["friction"]
    yield "m_p", links["platform_mass"] + links["payload"]
    yield "T_g", links["arm_mass"] * links["arm_com"] * _GRAVITY
    for joint in (1, 2, 3):
        yield (
            f"I_{joint}",
            links["arm_inertia"] + links["arm_mass"] * links["arm_com"] ** 2 + links["motor_inertia"],
        )
    for name, values in (("c_v", friction["viscous"]), ("c_c", friction["coulomb"])):
        for joint, value in enumerate(values, start=1):
            yield f"{name}{joint}", value
    yield "rod_inertia.m_d", links["rod_mass"]


def _parameters(
    effect: Mapping[str, Any], content: Mapping[str, Any], found: Mapping[str, Value]
) -> Iterator[tuple[str, float]]:
    """Yield the true values of an effect's parameters, by the names that they have in a model."""
    prefix = f"{effect['name']}."
    own = {name.removeprefix(prefix): value for name, (value, _) in found.items() if name.startswith(prefix)}
    for name, joint, value in _identified(effect, content, own):
        yield f"{prefix}{name}" if name in own else f"{prefix}{name}{joint}", value


def _lines(document: Mapping[str, Any]) -> Iterator[str]:
    for effect in document["hidden"]:
        values = ", ".join(f"{name} = {_short(value)}" for name, value in effect["identified"].items())
        verdict = f": {effect['verdict']}" if "verdict" in effect else ""
        joints = f" on joint {_listed(effect['joints'])}" if effect["joints"] else ""
        since = f" from {effect['at']:g} s on" if "at" in effect else ""
        yield f"hidden: {effect['name']}{joints}{since} ({values}){verdict}"
    if not document["hidden"]:
        yield "hidden: nothing"
    if document["found"] is None:
        return
    for name in document["not_hidden"]:
        yield f"found, but not hidden: {name}"
    width = max((len(name) for name in document["parameters"]), default=0)
    for name, entry in document["parameters"].items():
        true = "-" if entry["true"] is None else f"{entry['true']:.4g}"
        interval = "95 %: {:.4g} to {:.4g}".format(*entry["ci95"]) if entry["ci95"] else "no interval"
        yield f"  {name:<{width}}  true {true:>10}  found {entry['found']:10.4g}  {interval}"


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _listed(joints: Sequence[int]) -> str:
    return ", ".join(map(str, joints))
