"""FMU that wraps the C code: model exchange and co-simulation in one file, for this machine, with its sources.

The inverse model has inputs q_i, qd_i, qdd_i and outputs tau_i; the forward plant has inputs tau_i, and its motion as
states and outputs. Both have inputs temperature_i where the model needs them. The C compiler of this machine makes
the shared object: $CC, else cc.
"""

import hashlib
import os
import platform
import shutil
import struct
import subprocess
import tempfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Literal
from zipfile import ZIP_DEFLATED, ZipFile

from ident.estimation.settings import Meaning
from ident.export import c_source
from ident.export.losses import Carried
from ident.export.targets import ExportRequest, c
from ident.export.targets import beside as carried_file
from ident.identification.model import Model
from recordings.errors import BadInput
from recordings.files import replacement

__all__ = ["Settings", "carried_file", "write"]

NAME = "delta_model"
_SYSTEMS = {"Linux": ("linux", ".so"), "Darwin": ("darwin", ".dylib"), "Windows": ("win", ".dll")}
_UNITS = {
    "rad": {"rad": "1"},
    "rad/s": {"rad": "1", "s": "-1"},
    "rad/s2": {"rad": "1", "s": "-2"},
    "m": {"m": "1"},
    "m/s": {"m": "1", "s": "-1"},
    "m/s2": {"m": "1", "s": "-2"},
    "N.m": {"kg": "1", "m": "2", "s": "-2"},
    "N": {"kg": "1", "m": "1", "s": "-2"},
    "s": {"s": "1"},
    "degC": {"K": "1", "offset": "273.15"},
}
"""Units of the variables by exponents of SI units."""


@dataclass(frozen=True)
class Settings:
    """Settings of an FMU."""

    fmi: Annotated[Literal["2", "3"], Meaning("version of the interface")] = "2"
    plant: Annotated[
        Literal["inverse", "forward"], Meaning("motion in, torque out; or torque of the motors in, motion out")
    ] = "inverse"
    smooth_velocity: Annotated[float, Meaning("as for c")] = 0.0

    def __post_init__(self) -> None:
        self.code  # noqa: B018 - checks

    @property
    def code(self) -> c.Settings:
        """Settings of the C code."""
        return c.Settings(smooth_velocity=self.smooth_velocity)


@dataclass(frozen=True)
class _Variable:
    """One variable; its place in the list is its reference."""

    name: str
    causality: Literal["input", "output"]
    unit: str
    start: float | None = None
    """None: it is computed."""
    derivative_of: int | None = None
    depends_on: tuple[int, ...] | None = None
    """References of what an output depends on at the same instant; None of a state, which depends on itself."""

    @property
    def initial(self) -> str:
        """Of an output: whether its start value is given or computed; of an input empty."""
        return "" if self.causality == "input" else "calculated" if self.start is None else "exact"


def write(request: ExportRequest) -> Carried:
    """See `Target`.

    Raises:
        BadInput: there is no C compiler, or single precision is asked for: the interface has double numbers.
    """
    if request.precision != "double":
        raise BadInput("an FMU computes in double precision, float found; leave the precision out, or export c")
    compiler = shutil.which(os.environ.get("CC", "cc"))
    if compiler is None:
        raise BadInput("a C compiler (cc, or $CC) expected for an FMU, none found; install gcc, or export c")
    carried, settings = c.carried_by(request.model), request.settings
    files = _files(request, carried)
    sources = {name: text for name, text in files.items() if name.endswith((".c", ".h"))}
    folder, suffix = _platform(settings.fmi)
    with replacement(request.out) as partial, ZipFile(partial, "w", ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", files[f"fmi{settings.fmi}_description.xml"])
        for name, text in sources.items():
            archive.writestr(f"sources/{name}", text)
        if settings.fmi == "3":
            archive.writestr("sources/buildDescription.xml", files["fmi3_build.xml"])
        archive.writestr(f"binaries/{folder}/{NAME}{suffix}", _compiled(compiler, sources, suffix))
    return carried


def _files(request: ExportRequest, carried: Carried) -> dict[str, str]:
    """Code and descriptions by name; they hold the digest of all code as their identity."""
    settings, variables = request.settings, _variables(request.model, request.settings.plant)
    code = f"fmi{settings.fmi}_{NAME}.c", f"fmu_{NAME}.h"
    descriptions = f"fmi{settings.fmi}_description.xml", "fmi3_build.xml"
    numbered, of_time = list(enumerate(variables)), {"s"} if settings.fmi == "3" else set()
    values = {
        "plant": settings.plant,
        "wrapper": code[0],
        "version": version("delta-workbench"),
        "step": repr(1 / request.path.rate),
        "variables": variables,
        "units": {name: _UNITS[name] for name in sorted({each.unit for each in variables} | of_time)},
        "structure": {
            "Outputs": [k for k, each in numbered if each.causality == "output"],
            "Derivatives": [k for k, each in numbered if each.derivative_of is not None],
            "InitialUnknowns": [k for k, each in numbered if each.initial == "calculated"],
        },
    }
    more = (*code, *descriptions)
    files = c_source.files(request.model, carried.carried, "double", settings.code, request.digest, more, values)
    del files["example.c"]
    parts = [text for name, text in files.items() if name not in descriptions]
    guid = hashlib.sha256("".join(parts).encode()).hexdigest()[:32]
    return {name: text.replace(c_source.GUID, guid) for name, text in files.items()}


def _platform(fmi: str) -> tuple[str, str]:
    """Folder of the binary in the archive, and the ending of its name."""
    system, suffix = _SYSTEMS.get(platform.system(), ("linux", ".so"))
    if fmi == "2":
        return f"{system}{8 * struct.calcsize('P')}", suffix
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    return f"{machine}-{'windows' if system == 'win' else system}", suffix


def _compiled(compiler: str, sources: dict[str, str], suffix: str) -> bytes:
    """The shared object."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        codes = [file for file in sources if file.endswith(".c")]
        words = [compiler, "-std=c99", "-O2", "-shared", "-fPIC", *codes, "-lm", "-o", f"{NAME}{suffix}"]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            error = next(iter(done.stderr.splitlines()), "no message")
            raise BadInput(f"a compiler for C99 expected, {compiler} found: {error}; set $CC to another one")
        return (folder / f"{NAME}{suffix}").read_bytes()


def _variables(model: Model, plant: str) -> list[_Variable]:
    """Variables in the order of the wrapper."""
    joints = list(enumerate(model.file.effort_units, start=1))
    units = {unit: ("rad" if unit == "N m" else "m") for unit in model.file.effort_units}
    warm = [_Variable(f"temperature_{j}", "input", "degC", 25.0) for j, _ in joints]
    warm = warm if c_source.needs_temperature(model) else []
    position, velocity = ([(f"{x}_{j}", units[u] + per) for j, u in joints] for x, per in (("q", ""), ("qd", "/s")))
    acceleration = [(f"qdd_{j}", f"{units[u]}/s2") for j, u in joints]
    torque = [(f"tau_{j}", u.replace(" ", ".")) for j, u in joints]
    if plant == "inverse":
        inputs = [_Variable(name, "input", unit, 0.0) for name, unit in (*position, *velocity, *acceleration)] + warm
        every = tuple(range(len(inputs)))
        return inputs + [_Variable(name, "output", unit, depends_on=every) for name, unit in torque]
    inputs = [_Variable(name, "input", unit, 0.0) for name, unit in torque] + warm
    first, dof = len(inputs), len(joints)
    every = tuple(range(first + 2 * dof))
    return [
        *inputs,
        *(_Variable(name, "output", unit, 0.0) for name, unit in position),
        *(_Variable(name, "output", unit, 0.0, first + i) for i, (name, unit) in enumerate(velocity)),
        *(
            _Variable(name, "output", unit, None, first + dof + i, every)
            for i, (name, unit) in enumerate(acceleration)
        ),
    ]
