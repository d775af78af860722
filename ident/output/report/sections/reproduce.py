"""Section with the commands that reproduce the report."""

import os
import platform
import shlex
from importlib.metadata import version
from pathlib import Path

from ident.diagnosis.diagnosis import DiagnosisOptions
from ident.output.report.blocks import Code, ReportBlock, ReportSection, Text
from ident.output.report.contents import ReportContents, ReportRequest
from ident.output.tables import ResultTable
from recordings.command_line import repeated
from recordings.files import sha256
from recordings.reader import path_of

PACKAGES = ("delta-workbench", "numpy", "scipy", "numba", "plotly")


def section(contents: ReportContents) -> ReportSection:
    """Return commands, versions and digests."""
    read = {recording.path: recording for recording in contents.recordings}
    digests = [
        (name, read[path].digest if path in read else sha256(path))
        for path, name in file_names(contents.request).items()
    ]
    versions = [("Python", platform.python_version()), *((name, version(name)) for name in PACKAGES)]
    blocks: list[ReportBlock] = [
        Text(("In the folder that holds the files, or their folders:",)),
        Code(tuple(shlex.join(["ident", *line]) for line in commands(contents))),
        ResultTable(("file", "SHA-256"), digests, words=(0, 1)),
        ResultTable(("software", "version"), versions, words=(0, 1)),
    ]
    if contents.models:
        rows = [
            (
                name,
                model.software,
                model.method.name,
                str(model.method.seed),
                ", ".join(s.name for s in model.train.recordings),
            )
            for name, model in contents.models.items()
        ]
        blocks.append(ResultTable(("model", "software", "method", "seed", "fitted to"), rows, words=(0, 1, 2, 4)))
    return ReportSection("reproduce", "How to reproduce it", tuple(blocks))


def file_names(request: ReportRequest) -> dict[Path, str]:
    """Return the name of each file; if two are equal, the paths relative to the innermost common folder."""
    base_model = (request.base_model,) if request.base_model else ()
    inputs = (*request.models, *map(path_of, (*request.recordings, *request.held_out)))
    files = (*inputs, *base_model, *request.effect_files, *request.responses)
    if len({path.name for path in files}) == len(files):
        return {path: path.name for path in files}
    folder = os.path.commonpath([path.absolute().parent for path in files])
    return {path: Path(os.path.relpath(path, folder)).as_posix() for path in files}


def commands(contents: ReportContents) -> list[list[str]]:
    """Return the commands that make this report, and those that print its numbers as JSON."""
    request = contents.request
    names = file_names(request)
    models, recorded, held_out = (
        [names[path_of(each)] for each in files] for files in (request.models, request.recordings, request.held_out)
    )
    extra = repeated("--effect-file", (names[path] for path in request.effect_files))
    validate = repeated("--validate", held_out)
    lines = []
    if models:
        responses = repeated("--response", (names[path] for path in request.responses))
        no_diagnose = [] if request.diagnose else ["--no-diagnose"]
        lines.append(["report", *models, *recorded, *validate, *responses, *extra, *no_diagnose, "-o", "report.html"])
        lines += [["response", names[path], "--json"] for path in request.responses]
        groups = [recorded, *([held_out] if held_out else [])]
        lines += [["compare", model, *group, *extra, "--json"] for group in groups for model in models]
    if contents.diagnosis:
        start = ["--model", names[request.base_model]] if request.base_model else []
        chosen, default = contents.diagnosis.options, DiagnosisOptions()
        options = [*repeated("--only", chosen.only), *repeated("--without", chosen.without)]
        if chosen.preprocessing != default.preprocessing:
            options += ["--preprocess", chosen.preprocessing]
        if chosen.cutoff:
            options += ["--cutoff", f"{chosen.cutoff:g}"]
        lines.append(["diagnose", *recorded, *validate, *start, *extra, *options, "--json"])
    return lines
