"""Section with the commands that reproduce the report."""

import os
import platform
import shlex
from importlib.metadata import version
from pathlib import Path

from ident.diagnosis.diagnosis import DiagnosisOptions
from ident.output.report.blocks import Code, ReportBlock, ReportSection, ReportTable, Text
from ident.output.report.contents import ReportContents, ReportRequest
from recordings.command_line import repeated
from recordings.files import sha256

PACKAGES = ("delta-workbench", "numpy", "scipy", "numba", "plotly")


def section(contents: ReportContents) -> ReportSection:
    """Return commands, versions and digests."""
    request = contents.request
    digests = [(name, sha256(path)) for path, name in file_names(request).items()]
    versions = [("Python", platform.python_version()), *((name, version(name)) for name in PACKAGES)]
    models = tuple(
        (
            name,
            model.software,
            model.method.name,
            str(model.method.seed),
            ", ".join(s.name for s in model.train.recordings),
        )
        for name, model in contents.models.items()
    )
    blocks: list[ReportBlock] = [
        Text(("In the folder that holds the files, or their folders:",)),
        Code(tuple(shlex.join(["ident", *line]) for line in commands(contents))),
        ReportTable(("file", "SHA-256"), tuple(digests), words=(0, 1)),
        ReportTable(("software", "version"), tuple(versions), words=(0, 1)),
    ]
    if models:
        blocks.append(ReportTable(("model", "software", "method", "seed", "fitted to"), models, words=(0, 1, 2, 4)))
    return ReportSection("reproduce", "How to reproduce it", tuple(blocks))


def file_names(request: ReportRequest) -> dict[Path, str]:
    """Return the name of each file; if two are equal, the paths relative to the innermost common folder."""
    base_model = (request.base_model,) if request.base_model else ()
    files = (
        *request.models,
        *request.recordings,
        *request.held_out,
        *base_model,
        *request.effect_files,
        *request.responses,
    )
    if len({path.name for path in files}) == len(files):
        return {path: path.name for path in files}
    folder = os.path.commonpath([path.absolute().parent for path in files])
    return {path: Path(os.path.relpath(path, folder)).as_posix() for path in files}


def commands(contents: ReportContents) -> list[list[str]]:
    """Return the commands that make this report, and those that print its numbers as JSON."""
    request = contents.request
    names = file_names(request)
    models, recorded, held_out = (
        [names[path] for path in files] for files in (request.models, request.recordings, request.held_out)
    )
    extra = repeated("--effect-file", (names[path] for path in request.effect_files))
    validate = repeated("--validate", held_out)
    lines = []
    if models:
        responses = [word for path in request.responses for word in ("--response", names[path])]
        no_diagnose = [] if request.diagnose else ["--no-diagnose"]
        lines.append(["report", *models, *recorded, *validate, *responses, *extra, *no_diagnose, "-o", "report.html"])
        groups = [recorded, *([held_out] if held_out else [])]
        lines += [["response", names[path], "--json"] for path in request.responses]
        lines += [["compare", model, *group, *extra, "--json"] for group in groups for model in models]
    if contents.diagnosis:
        start = ["--model", names[request.base_model]] if request.base_model else []
        options = _chosen_options(contents.diagnosis.options)
        lines.append(["diagnose", *recorded, *validate, *start, *extra, *options, "--json"])
    return lines


def _chosen_options(options: DiagnosisOptions) -> list[str]:
    """Return the options of a diagnosis that are not the defaults."""
    default = DiagnosisOptions()
    preprocess = ["--preprocess", options.preprocessing] if options.preprocessing != default.preprocessing else []
    cutoff = ["--cutoff", f"{options.cutoff:g}"] if options.cutoff else []
    effects = [("--only", effect) for effect in options.only] + [("--without", effect) for effect in options.without]
    return [*preprocess, *cutoff, *(word for option in effects for word in option)]
