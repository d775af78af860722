"""Show a study of swarms: table, sentences about Remarks 1 and 2, picture, CSV."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rich.console import Console

from delta_web.palette import CATEGORIES
from ident.output.console.printing import print_plain, print_table
from ident.output.pictures import figure
from ident.output.tables import ResultTable
from ident.paper.figures import write_csv
from ident.paper.study import TARGETS, TOPOLOGIES, SwarmGroup, SwarmStudy
from recordings.recording import Floats

LABELS = {"pso": "cyclic", "pso_classic": "classical"}
NEAR, REACHED = TARGETS


def show(study: SwarmStudy, console: Console) -> None:
    """Print one row for each group, and what it says about the remarks."""
    seeds = len(study.groups[0].runs)
    title = (
        f"Remarks 1 and 2: swarms from {seeds} seed{'s' if seeds > 1 else ''}, above the certified minimum of (33)"
    )
    head = ("swarm", "N_p", "median", "worst", f"to {NEAR:g}", f"to {REACHED:g}", "(41) ±", "par. ±")
    ends = [number for number, group in enumerate(study.groups) if group.method == TOPOLOGIES[-1]]
    print_table(console, ResultTable(head, list(map(_row, study.groups)), title=title, sections=ends))
    print_plain(
        console,
        f"cyclic: pso, with {study.groups[0].neighbours} neighbours in the first row, and this share of the "
        "particles in the others; classical: pso_classic. "
        "median, worst: relative excess at the end. to: median number of iterations, and how many seeds arrive. "
        "±: largest difference between two seeds, of Eq. (41) on validation data and of a parameter relative to "
        "itself.",
    )
    for sentence in sentences(study):
        print_plain(console, sentence)


def _row(group: SwarmGroup) -> list[str]:
    arrivals = [(steps, len(steps)) for steps in map(group.reached, TARGETS)]
    return [
        LABELS[group.method],
        str(group.particles),
        f"{np.median(group.excess):.0e}",
        f"{group.excess.max():.0e}",
        *(f"{np.median(steps):.0f} ({count})" if count else "never" for steps, count in arrivals),
        f"{group.nrmse_range:.0e}",
        f"{group.parameter_range:.0e}",
    ]


def sentences(study: SwarmStudy) -> Iterator[str]:
    """Say what the study shows of Remark 1 (topology) and Remark 2 (size of the swarm)."""
    for size in study.sizes:
        cyclic, classical = (study.group(method, size) for method in TOPOLOGIES)
        worse = float(np.median(classical.excess)) > float(np.median(cyclic.excess))
        yield (
            f"Remark 1 with {size} particles: the classical swarm ends "
            f"{'farther from' if worse else 'no farther from'} the minimum than the cyclic one "
            f"({np.median(classical.excess):.0e} and {np.median(cyclic.excess):.0e}, medians); it comes within "
            f"{REACHED:g} from {len(classical.reached(REACHED))} of {len(classical.runs)} seeds, the cyclic one from "
            f"{len(cyclic.reached(REACHED))}."
        )
    enough = [
        size
        for size in sorted(study.sizes)
        if len((group := study.group("pso", size)).reached(REACHED)) == len(group.runs)
    ]
    verdict = f"{enough[0]} particles are enough" if enough else "no size is enough"
    yield f"Remark 2: {verdict} for the cyclic swarm to come within {REACHED:g} of the minimum from every seed."


def draw(study: SwarmStudy, path: Path) -> None:
    """Draw, for each size, how the excess and the spread of the particles fall: median and range of the seeds."""
    sizes = study.sizes
    title = f"Remarks 1 and 2: swarms of several sizes and seeds\n{study.source}"
    with figure(path, title, 2.2 + 3.2 * len(sizes), 6.6) as canvas:
        axes = canvas.subplots(2, len(sizes), sharex=True, sharey="row", squeeze=False)
        for column, size in enumerate(sizes):
            for method, colour in zip(TOPOLOGIES, CATEGORIES, strict=False):
                group = study.group(method, size)
                for axis, (lowest, median, highest) in zip(axes[:, column], _ranges(group), strict=True):
                    axis.fill_between(np.arange(len(median)), lowest, highest, color=colour, alpha=0.25, lw=0)
                    axis.semilogy(median, color=colour, lw=1.4, label=LABELS[method])
            axes[0, column].set_title(f"{size} particles", fontsize=10)
            axes[1, column].set_xlabel("iteration")
        axes[0, 0].set_ylabel("objective above its\nminimum, relative")
        axes[1, 0].set_ylabel("spread of the particles,\nrelative to the start")
        axes[0, 0].legend(loc="lower left", frameon=False)


def _ranges(group: SwarmGroup) -> Iterator[tuple[Floats, Floats, Floats]]:
    """Lowest, median and highest (iterations + 1,) excess, and spread, of all seeds.

    A run that has ended stays where it is. Zero, which a logarithm does not show, becomes round-off.
    """
    length = max(len(run.excess) for run in group.runs)
    for name in ("excess", "spread"):
        curves = [np.pad(values := getattr(run, name), (0, length - len(values)), "edge") for run in group.runs]
        lowest, median, highest = np.maximum(np.quantile(curves, [0, 0.5, 1], axis=0), 1e-16)
        yield lowest, median, highest


def write(study: SwarmStudy, folder: Path) -> None:
    """Write one row for each run (`study.csv`), and the convergence of each group (`convergence.csv`)."""
    joints = range(1, len(study.groups[0].runs[0].nrmse) + 1)
    header = [
        "method",
        "particles",
        "neighbours",
        "seed",
        "excess",
        *(f"iterations_to_{target:g}" for target in TARGETS),
    ]
    write_csv(
        folder / "study.csv",
        [*header, *(f"nrmse_{joint}" for joint in joints), *study.parameter_names],
        [
            [
                group.method,
                group.particles,
                group.neighbours,
                run.seed,
                float(run.excess[-1]),
                *(run.iterations_to(target) for target in TARGETS),
                *run.nrmse,
                *run.parameters.tolist(),
            ]
            for group in study.groups
            for run in group.runs
        ],
    )
    rows: list[list[object]] = []
    for group in study.groups:
        excess, spread = _ranges(group)
        rows += [
            [group.method, group.particles, step, *values]
            for step, values in enumerate(np.transpose([*excess, *spread]))
        ]
    statistics = [f"{name}_{part}" for name in ("excess", "spread") for part in ("lowest", "median", "highest")]
    write_csv(folder / "convergence.csv", ["method", "particles", "iteration", *statistics], rows)
