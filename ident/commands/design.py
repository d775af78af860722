"""`ident design`: the motion to record next."""

from __future__ import annotations

from itertools import chain
from pathlib import Path
from typing import Literal

import click

from ident.basics import plugins
from ident.command_options import (
    EFFECT_FILES,
    FILE,
    JSON,
    RuledCommand,
    check_choices,
    ends,
    excludes,
    needs,
    say_written,
    show_result,
)
from recordings.command_line import FiniteRange, IntegerRange, NameChoice, output_name, refuse_existing, say, say_next
from recordings.errors import BadInput
from recordings.next_command import OWN_RIG

_TWO_NAMES_EXPECTED = (
    "--discriminate: the names of two effects expected, such as --discriminate arm_com_offset joint_spring, fewer "
    "found; name both (ident effects lists them)"
)


class _Command(RuledCommand):
    """Command that explains a missing name after --discriminate."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        try:
            return super().parse_args(ctx, args)
        except click.BadOptionUsage as error:
            if error.option_name != "--discriminate":
                raise
            raise BadInput(_TWO_NAMES_EXPECTED) from None


Pairs = tuple[tuple[str, str], ...]


def _pairs(ctx: click.Context, parameter: click.Parameter, pairs: Pairs) -> Pairs:
    if any(name.startswith("-") for pair in pairs for name in pair):  # click takes the next option for a name
        raise BadInput(_TWO_NAMES_EXPECTED)
    return pairs


@click.command(
    cls=_Command,
    rules=[
        excludes("--discriminate", "--with"),
        excludes("--discriminate", "--criterion", note=" (which has its own)"),
        needs("--joint", "--discriminate", "add it, or leave --joint out"),
        excludes("--recording", "--rig", note=" (which contains its rig)"),
        ends("--out", ".toml", "a trajectory file", "give another name"),
    ],
    epilog="Example: ident design --rig bench.toml -o best.toml, then: daq record --traj best.toml",
)
@click.option("--rig", "rig_file", type=FILE, metavar="FILE", help="Rig file (TOML).  [default: the simulated rig]")
@click.option(
    "--criterion",
    type=NameChoice(["d", "e"]),
    help="d: minimise the uncertainty of all parameters together; e: the largest uncertainty of any.  [default: d]",
)
@click.option(
    "--with",
    "effects",
    type=NameChoice(plugins.names("ident.dynamics.effects.library")),
    multiple=True,
    help="Include the parameters of this effect. May be repeated.",
)
@click.option(
    "--discriminate",
    "pairs",
    nargs=2,
    multiple=True,
    metavar="A B",
    callback=_pairs,
    help="Instead, find the motion that best separates the effects A and B (see ident effects). May be repeated.",
)
@click.option(
    "--joint",
    "joints",
    type=IntegerRange(min=1),
    multiple=True,
    help="Joint on which the effect is, whether A or B. May be repeated.  [default: any]",
)
@click.option(
    "--recording",
    "recordings",
    type=FILE,
    multiple=True,
    metavar="FILE",
    help="Use the rig of this recording, and separate A from B by both motions together. May be repeated.",
)
@EFFECT_FILES
@click.option("--period", type=FiniteRange(min=0.5, max=60), default=5.0, show_default=True, metavar="S")
@click.option(
    "--harmonics",
    type=IntegerRange(min=1, max=20),
    default=6,
    show_default=True,
    metavar="N",
    help="Number of harmonics of the period.",
)
@click.option(
    "--against", metavar="TRAJ", help="Compare with this trajectory.  [default: excitation, for a delta robot]"
)
@click.option(
    "--noise",
    type=FiniteRange(min=0, min_open=True),
    default=0.1,
    show_default=True,
    help="RMS noise of the torque for which standard errors are computed [N m or N].",
)
@click.option(
    "--seed", type=IntegerRange(min=0), default=0, show_default=True, help="Seed of the random starting points."
)
@click.option("-o", "--out", type=FILE, metavar="FILE", help="Trajectory file to write.  [default: design.toml]")
@click.option("--force", is_flag=True, help="Replace an existing trajectory file.")
@JSON
def command(
    rig_file: Path | None,
    criterion: Literal["d", "e"] | None,
    effects: tuple[str, ...],
    pairs: Pairs,
    joints: tuple[int, ...],
    recordings: tuple[Path, ...],
    effect_files: tuple[Path, ...],
    period: float,
    harmonics: int,
    against: str | None,
    noise: float,
    seed: int,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Find the motion within the rig's limits that determines the parameters best.

    Writes a trajectory file for `daq record --traj`, a Fourier series of every joint. Shows the expected standard
    errors and the used share of each limit.
    """
    if against and pairs and recordings:
        raise BadInput("--against or --recording (with which it is compared) expected, both found; leave one out")

    from functools import partial

    from ident.design.designs import DesignRequest, design_discrimination, design_excitation
    from ident.design.model import with_effects
    from ident.design.recorded import read_recorded_motions
    from ident.dynamics.effects.library import library
    from ident.output.console import design
    from recordings.progress import progress_bar
    from recordings.rig import is_default, load_rig, simulated_rig

    check_choices((*effects, *chain.from_iterable(pairs)), effect_files)
    recorded = read_recorded_motions(recordings)
    rig = recorded[0].rig if recorded else load_rig(rig_file, driven=False) if rig_file else simulated_rig()
    out = output_name(out, Path("design.toml"), force)
    refuse_existing(out, force=force)
    order = DesignRequest(out.name, rig, period, harmonics, against, noise, seed)
    with progress_bar("searching") as show:
        progress = partial(show, "searching")
        if pairs:
            outcome, series = design_discrimination(
                order, pairs, library(effect_files), [joint - 1 for joint in joints], recorded, progress
            )
        else:
            outcome, series = design_excitation(order, with_effects(rig, effects), criterion or "d", progress)
    out.write_text(series.as_toml(), encoding="utf-8")
    show_result(as_json, partial(design.as_json, outcome), partial(design.show, outcome))
    say_written(trajectory=out)
    if rig_file or is_default(rig):
        say_next("daq", "record", "--traj", out, *(["--rig", rig_file] if rig_file else []))
    else:
        say(OWN_RIG)
        say_next("daq", "record", "--traj", out, "--rig", "RIG.toml")
