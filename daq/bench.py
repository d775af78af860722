"""The rig on which a motion runs: its drives, or simulated ones inside this program."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from daq.cycle.stopping import check_stoppable
from daq.hidden_seed import HiddenSeed
from daq.simulation import configured, simulated
from drivers import transports
from drivers.simulated.seal import sealed_path
from recordings.command_line import say
from recordings.errors import BadInput, RunFailed
from recordings.recording import Pace
from recordings.rig import Rig


@dataclass(frozen=True)
class Bench:
    """A rig, and how its drives are reached."""

    rig: Rig
    pace: Pace
    sim_file: Path | None = None
    hidden: HiddenSeed | None = None
    """Seed from which hidden effects of the simulated machine are drawn."""
    seed: int | None = 0
    """Seed of the noise of the simulated rig; None: the drives are real."""
    accepted: frozenset[str] = frozenset()
    """What is accepted by name."""
    payload: float = 0.0
    """Mass that a simulated robot carries besides [kg]."""

    @classmethod
    def of(
        cls,
        rig: Rig,
        pace: str | None = None,
        sim_file: Path | None = None,
        hidden: HiddenSeed | None = None,
        seed: int = 0,
        accepted: Iterable[str] = (),
    ) -> "Bench":
        """The drives of `rig`; simulated ones run in lockstep unless `pace` says otherwise.

        Raises:
            BadInput: a sim file or hidden effects for real drives.
        """
        is_simulated = transports.of(rig).simulated_here(rig)
        if not is_simulated and (sim_file or hidden is not None):
            raise BadInput("--sim and --hidden are for drives simulated inside this program; give them to `daq sim`")
        lockstep = pace == "lockstep" or (pace is None and is_simulated)
        chosen: Pace = "lockstep" if lockstep else "realtime"
        return cls(rig, chosen, sim_file, hidden, seed if is_simulated else None, frozenset(accepted))

    @property
    def simulated(self) -> bool:
        """Whether the drives are simulated inside this program."""
        return self.seed is not None

    def unit(self, joint: int) -> str:
        """Unit of the position of `joint`.

        Raises:
            BadInput: there is no such joint.
        """
        if not 1 <= joint <= self.rig.dof:
            raise BadInput(f"--joint: 1 to {self.rig.dof} expected, {joint} found")
        return self.rig.position_units[joint - 1]

    def announce(self, motion: str) -> None:
        """Say on stderr what moves.

        Raises:
            BadInput: real drives would, and nothing could ask this program to stop.
        """
        if self.simulated:
            say("SIMULATED RIG: no real drive is connected; what is recorded comes from a simulated robot.", "yellow")
        else:
            check_stoppable()
        say(f"{self.rig.name}: {motion}, {self.pace}")

    @contextmanager
    def serve(self, recording: Path | None = None) -> Iterator[None]:
        """Run the simulated drives, if they are simulated; hidden effects are sealed beside the `recording`, if any.

        Raises:
            RunFailed: as in the block; says so if the simulation itself failed.
        """
        if self.seed is None:
            yield
            return
        config = configured(self.rig, self.sim_file, self.hidden, recording and sealed_path(recording))
        links = config.links.model_copy(update={"payload": config.links.payload + self.payload})
        config = config.model_copy(update={"links": links})
        with simulated(self.rig, config, self.pace, self.seed) as machine:
            try:
                yield
            except RunFailed as error:
                if machine.error is None:
                    raise
                raise RunFailed(f"{error}; the simulated rig itself stopped: {machine.error!r}") from machine.error
