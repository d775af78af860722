"""Section with the commands that reproduce the report."""

import os
import platform
import shlex
from importlib.metadata import version
from pathlib import Path

from ident.output.report.blocks import Code, ReportBlock, ReportSection, ReportTable, Text
from ident.output.report.contents import ReportContents, ReportRequest

PACKAGES = ("delta-workbench", "numpy", "scipy", "numba", "plotly")


def section(contents: ReportContents) -> ReportSection:
    """Return commands, versions and digests."""
    request = contents.request
    names = file_names(request)
    files = [*request.models, *request.recordings, *request.held_out]
    values = [*contents.digests.values(), *(source.sha256 for source in contents.sources)]
    digests = [(names[path], digest) for path, digest in zip(files, values, strict=True)]
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
        ReportTable(("model", "software", "method", "seed", "fitted to"), models, words=(0, 1, 2, 4)),
        ReportTable(("software", "version"), tuple(versions), words=(0, 1)),
    ]
    return ReportSection("reproduce", "How to reproduce it", tuple(blocks))


def file_names(request: ReportRequest) -> dict[Path, str]:
    """Return the name of each file; if two are equal, the paths relative to the innermost common folder."""
    files = (*request.models, *request.recordings, *request.held_out, *request.effect_files)
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
    extra = [word for path in request.effect_files for word in ("--effect-file", names[path])]
    validate = [word for name in held_out for word in ("--validate", name)]
    no_diagnose = [] if request.diagnose else ["--no-diagnose"]
    lines = [["report", *models, *recorded, *validate, *extra, *no_diagnose, "-o", "report.html"]]
    groups = [recorded, *([held_out] if held_out else [])]
    lines += [["compare", model, *group, *extra, "--json"] for group in groups for model in models]
    if request.diagnose:
        lines.append(["diagnose", *recorded, *validate, *extra, "--json"])
    return lines
