"""Options that several commands of `daq` have in common."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from daq.hidden_seed import HiddenSeed, hidden_seed
from recordings.command_line import FiniteRange, IntegerRange, NameChoice, say_next
from recordings.errors import BadInput

if TYPE_CHECKING:
    from daq.bench import Bench
    from recordings.rig import Rig
    from recordings.urdf import Payload

FILE = click.Path(path_type=Path)

RIG = click.option("--rig", "rig_file", type=FILE, help="Rig file (TOML). Without it: the simulated rig.")
RATE = click.option(
    "--rate", type=FiniteRange(0, min_open=True), help="Cycles per second [Hz].  [default: the rig's]"
)
PACE = click.option(
    "--pace", type=NameChoice(["lockstep", "realtime"]), help="Simulated rig only.  [default: lockstep]"
)
SEED = click.option("--seed", type=IntegerRange(0), default=0, show_default=True, help="Noise of the simulated rig.")
SIM = click.option(
    "--sim",
    "sim_file",
    type=FILE,
    help="What the simulated machine really is: a sim file (TOML), or a shipped robot: heavy, light, paper_friction.",
)
HIDDEN = click.option(
    "--hidden",
    metavar="SEED[@S]",
    callback=hidden_seed,
    help="Hide effects drawn from this seed in the simulated machine; with @S they begin at that second.",
)
ACCEPT = click.option(
    "--accept",
    multiple=True,
    type=NameChoice(["pose"]),
    help="Accept by name what is refused: a pose that is whole motor turns from the last one.",
)


def _payload(context: click.Context, option: click.Parameter, text: str | None) -> "Payload | None":
    """What is mounted: a mass, with its centre behind @, or that both are unknown."""
    from recordings.urdf import Payload

    if text is None:
        return None
    mass, _, place = text.partition("@")
    content = {"mass": mass} | ({"com": place.split(",")} if place else {})
    try:
        return Payload.read(text, lambda _: Payload.model_validate(content, strict=False))
    except ValueError:
        raise BadInput(
            f"--payload: a mass [kg] as 1.5, with its centre [m] as 1.5@0,0,0.1, or unknown expected, {text!r} "
            "found; correct it"
        ) from None


PAYLOAD = click.option(
    "--payload",
    "mounted",
    metavar="KG[@X,Y,Z]",
    callback=_payload,
    help="What is mounted on the tool, with its centre [m] there; or unknown.  [default: as the rig file says]",
)
JSON = click.option("--json", "as_json", is_flag=True, help="One JSON document on stdout.")

Command = Callable[..., None]


@dataclass(frozen=True)
class DriveOptions:
    """Options that say which drives are commanded, and how."""

    rig_file: Path | None = None
    rate: float | None = None
    pace: str | None = None
    sim_file: Path | None = None
    hidden: HiddenSeed | None = None
    seed: int = 0
    accept: tuple[str, ...] = ()
    mounted: "Payload | None" = None
    """The payload."""

    def rig(self) -> "Rig":
        """The rig; raises BadInput where its file or the rate is not valid."""
        from recordings.rig import load_rig, simulated_rig

        rig = load_rig(self.rig_file) if self.rig_file else simulated_rig()
        rig = rig.model_copy(update={"payload": self.mounted}) if self.mounted else rig
        return rig if self.rate is None else rig.at_rate(self.rate)

    def bench(self) -> "Bench":
        """The rig and its drives; raises BadInput where an option does not suit them."""
        from daq.bench import Bench

        return Bench.of(self.rig(), self.pace, self.sim_file, self.hidden, self.seed, self.accept)

    @property
    def words(self) -> tuple[object, ...]:
        """What a command that comes next repeats."""
        options = {"--rig": self.rig_file, "--sim": self.sim_file}
        return tuple(word for pair in options.items() if pair[1] for word in pair)


def say_next_recording(rig: "Rig", drives: DriveOptions) -> None:
    """Say what records a first motion: the built-in ones move a delta robot, other joints need one of their own."""
    if rig.mechanism == "delta":
        pace = ("--pace", drives.pace) if drives.pace else ()
        say_next("daq", "record", "--traj", "fig5a", *drives.words, *pace)
    else:
        say_next("ident", "design", *replace(drives, sim_file=None).words)


def drive_options(*options: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Decorate a command with these `options` of its drives, which it gets together as `drives`."""

    def decorate(command: Command) -> Command:
        @wraps(command)
        def with_drives(**given: Any) -> None:
            names = [field.name for field in fields(DriveOptions) if field.name in given]
            command(drives=DriveOptions(**{name: given.pop(name) for name in names}), **given)

        decorated: Command = with_drives
        for option in reversed(options):
            decorated = option(decorated)
        return decorated

    return decorate
