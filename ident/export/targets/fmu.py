"""FMU (FMI 2.0, co-simulation) that wraps the C code: description, shared object for this machine, and sources.

Inputs are q_i, qd_i, qdd_i and, where the model needs it, temperature_i; outputs are tau_i. The C compiler of this
machine makes the shared object: $CC, else cc.
"""

import hashlib
import os
import platform
import shutil
import struct
import subprocess
import tempfile
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement
from zipfile import ZIP_DEFLATED, ZipFile

from ident.export import c_source
from ident.export.losses import Carried
from ident.export.targets import ExportRequest, c
from ident.export.targets import beside as carried_file
from ident.identification.model import Model
from recordings.errors import BadInput
from recordings.files import replacement

__all__ = ["carried_file", "write"]

NAME = "delta_model"
_WRAPPER = f"fmi2_{NAME}.c"
_SYSTEMS = {"Linux": ("linux", ".so"), "Darwin": ("darwin", ".dylib"), "Windows": ("win", ".dll")}


def write(request: ExportRequest) -> Carried:
    """See `Target`.

    Raises:
        BadInput: there is no C compiler, or single precision is asked for: the interface has double numbers.
    """
    if request.precision != "double":
        raise BadInput("an FMU computes in double precision, --precision float found; leave it out, or export c")
    compiler = shutil.which(os.environ.get("CC", "cc"))
    if compiler is None:
        raise BadInput("a C compiler (cc, or $CC) expected for an FMU, none found; install gcc, or export c")
    carried = c.carried_by(request.model)
    files = c_source.files(request.model, c.indices(request.model, carried), "double", (_WRAPPER,))
    sources = {name: text for name, text in files.items() if name != "example.c"}
    guid = hashlib.sha256("".join(sources.values()).encode()).hexdigest()[:32]
    sources[_WRAPPER] = sources[_WRAPPER].replace(c_source.GUID, guid)
    folder, suffix = _platform()
    with replacement(request.out) as partial, ZipFile(partial, "w", ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", _description(request, guid))
        for name, text in sources.items():
            archive.writestr(f"sources/{name}", text)
        archive.writestr(f"binaries/{folder}/{NAME}{suffix}", _compiled(compiler, sources, suffix))
    return carried


def _platform() -> tuple[str, str]:
    """Folder of the binary in the archive, and the ending of its name."""
    system, suffix = _SYSTEMS.get(platform.system(), ("linux", ".so"))
    return f"{system}{8 * struct.calcsize('P')}", suffix


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


def _description(request: ExportRequest, guid: str) -> str:
    """modelDescription.xml."""
    model = request.model
    root = Element(
        "fmiModelDescription", fmiVersion="2.0", modelName=NAME, guid=guid, numberOfEventIndicators="0",
        description="torque of an identified model", variableNamingConvention="flat",
        generationTool=f"delta-workbench {version('delta-workbench')}",
    )  # fmt: skip
    simulation = SubElement(root, "CoSimulation", modelIdentifier=NAME, canHandleVariableCommunicationStepSize="true")
    files = SubElement(simulation, "SourceFiles")
    for name in (f"{NAME}.c", _WRAPPER):
        SubElement(files, "File", name=name)
    SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(1 / request.path.rate))
    variables = SubElement(root, "ModelVariables")
    inputs = _inputs(model)
    for reference, (name, start) in enumerate(inputs.items()):
        variable = SubElement(
            variables, "ScalarVariable", name=name, valueReference=str(reference), causality="input",
            variability="continuous",
        )  # fmt: skip
        SubElement(variable, "Real", start=repr(start))
    outputs = [f"tau_{joint}" for joint in range(1, len(model.file.joints) + 1)]
    for reference, name in enumerate(outputs, start=len(inputs)):
        variable = SubElement(
            variables, "ScalarVariable", name=name, valueReference=str(reference), causality="output",
            variability="continuous", initial="calculated",
        )  # fmt: skip
        SubElement(variable, "Real")
    structure = SubElement(root, "ModelStructure")
    for kind in ("Outputs", "InitialUnknowns"):
        section = SubElement(structure, kind)
        for index in range(len(inputs) + 1, len(inputs) + len(outputs) + 1):
            SubElement(section, "Unknown", index=str(index))
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _inputs(model: Model) -> dict[str, float]:
    """Start values of the inputs by name, in the order of the wrapper."""
    joints = range(1, len(model.file.joints) + 1)
    names = {f"{name}_{joint}": 0.0 for name in ("q", "qd", "qdd") for joint in joints}
    warm = {f"temperature_{joint}": 25.0 for joint in joints} if c_source.needs_temperature(model) else {}
    return names | warm
