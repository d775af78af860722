"""How to reproduce the report."""

import platform
import shlex
from importlib.metadata import version

from ident.report.blocks import Block, Code, Section, Table, Text
from ident.report.material import Material

PACKAGES = ("delta-workbench", "numpy", "scipy", "numba", "plotly")


def section(material: Material) -> Section:
    """Commands, versions, digests."""
    digests = [*material.digests.items(), *((source.name, source.sha256) for source in material.sources)]
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
    blocks: list[Block] = [
        Text(("In the folder that holds the files:",)),
        Code(tuple(shlex.join(["ident", *line]) for line in commands(material))),
        Table(("file", "SHA-256"), tuple(digests), words=(0, 1)),
        Table(("model", "software", "method", "seed", "fitted to"), models, words=(0, 1, 2, 4)),
        Table(("software", "version"), tuple(versions), words=(0, 1)),
    ]
    return Section("reproduce", "How to reproduce it", tuple(blocks))


def commands(material: Material) -> list[list[str]]:
    """What makes this report, and the same numbers as JSON."""
    request = material.request
    models = [path.name for path in request.models]
    recorded, held = ([path.name for path in files] for files in (request.recordings, request.held_out))
    extra = [word for path in request.effect_files for word in ("--effect-file", path.name)]
    validate = [word for name in held for word in ("--validate", name)]
    asked = [] if request.diagnose else ["--no-diagnose"]
    lines = [["report", *models, *recorded, *validate, *extra, *asked, "-o", "report.html"]]
    groups = [recorded, *([held] if held else [])]
    lines += [["compare", model, *group, *extra, "--json"] for group in groups for model in models]
    if request.diagnose:
        lines.append(["diagnose", *recorded, *validate, *extra, "--json"])
    return lines
