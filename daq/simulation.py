"""Simulated rig of `daq record` and `daq sim`: its sim file, hidden effects and sealed truth."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from drivers import transports
from drivers.simulated import transports as simulations
from drivers.simulated.config import SimConfig, load_sim
from drivers.simulated.service import Service
from recordings.command_line import say
from recordings.errors import BadInput
from recordings.recording import Pace
from recordings.rig import Rig


def configured(rig: Rig, sim: Path | None, hidden: int | None, truth: Path) -> SimConfig:
    """Load the machine to simulate from the sim file, or draw its effects from the seed `hidden`.

    Hidden effects are written to the sealed file `truth`.

    Raises:
        BadInput: the sim file is not valid, effects come from both `sim` and `hidden`, or `truth` exists.
    """
    from drivers.simulated.hidden import draw
    from drivers.simulated.seal import seal
    from drivers.simulated.seal import truth as truth_about
    from drivers.simulated.sizing import resolve

    config = SimConfig() if sim is None else load_sim(sim)
    if hidden is not None:
        if config.effects:
            raise BadInput("either --hidden or a sim file with [[effects]] expected, both found; choose one")
        config = config.model_copy(update={"effects": draw(hidden, rig, config)})
    if not config.effects:
        return config
    if truth.exists():
        raise BadInput(f"{truth} exists and sealed truths are never overwritten; move it or choose another name")
    config = resolve(rig, config)
    seal(truth, truth_about(rig, config, hidden))
    return config


def simulated(rig: Rig, config: SimConfig, pace: Pace, seed: int) -> Service:
    """Serve the simulated rig on the bus or the lines of `rig`; the result is a context manager.

    Raises:
        BadInput: the bus cannot be opened.
    """
    service = simulations.of(rig).serve(rig, config, pace, seed)
    service.warn = lambda text: say(f"warning: {text}", "yellow")
    return service


@contextmanager
def served(rig: Rig) -> Iterator[None]:
    """Serve the default machine during the block if the drives of `rig` are simulated inside this program.

    Raises:
        BadInput: the bus cannot be opened.
    """
    if not transports.of(rig).simulated_here(rig):
        yield
        return
    with simulated(rig, SimConfig(), "lockstep", seed=0):
        yield
