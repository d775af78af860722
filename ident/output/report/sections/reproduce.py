"""How to reproduce the report."""

import os
import platform
import shlex
from importlib.metadata import version
from pathlib import Path

from ident.output.report.blocks import ReportBlock, Code, ReportSection, ReportTable, Text
from ident.output.report.contents import ReportContents, ReportRequest

PACKAGES = ("delta-workbench", "numpy", "scipy", "numba", "plotly")


def section(material: ReportContents) -> ReportSection:
    """Commands, versions, digests."""
    request = material.request
    known = file_names(request)
    files = [*request.models, *request.recordings, *request.held_out]
    values = [*material.digests.values(), *(source.sha256 for source in material.sources)]
    digests = [(known[path], digest) for path, digest in zip(files, values, strict=True)]
    versions = [("Python", platform.python_version()), *((name, version(name)) for name in PACKAGES)]
    models = tuple(
        (
            name,
            model.software,
            model.method.name,
            str(model.method.seed),
            ", ".join(s.name for s in model.train.recordings),
        )
        for name, model in material.models.items()
    )
    blocks: list[ReportBlock] = [
        Text(("In the folder that holds the files, or their folders:",)),
        Code(tuple(shlex.join(["ident", *line]) for line in commands(material))),
        ReportTable(("file", "SHA-256"), tuple(digests), words=(0, 1)),
        ReportTable(("model", "software", "method", "seed", "fitted to"), models, words=(0, 1, 2, 4)),
        ReportTable(("software", "version"), tuple(versions), words=(0, 1)),
    ]
    return ReportSection("reproduce", "How to reproduce it", tuple(blocks))


def file_names(request: ReportRequest) -> dict[Path, str]:
    """Of all files: their own where no two are alike, else from the innermost folder that holds all of them."""
    files = (*request.models, *request.recordings, *request.held_out, *request.effect_files)
    if len({path.name for path in files}) == len(files):
        return {path: path.name for path in files}
    folder = os.path.commonpath([path.absolute().parent for path in files])
    return {path: Path(os.path.relpath(path, folder)).as_posix() for path in files}


def commands(material: ReportContents) -> list[list[str]]:
    """What makes this report, and the same numbers as JSON."""
    request = material.request
    known = file_names(request)
    models, recorded, held = (
        [known[path] for path in files] for files in (request.models, request.recordings, request.held_out)
    )
    extra = [word for path in request.effect_files for word in ("--effect-file", known[path])]
    validate = [word for name in held for word in ("--validate", name)]
    asked = [] if request.diagnose else ["--no-diagnose"]
    lines = [["report", *models, *recorded, *validate, *extra, *asked, "-o", "report.html"]]
    groups = [recorded, *([held] if held else [])]
    lines += [["compare", model, *group, *extra, "--json"] for group in groups for model in models]
    if request.diagnose:
        lines.append(["diagnose", *recorded, *validate, *extra, "--json"])
    return lines
