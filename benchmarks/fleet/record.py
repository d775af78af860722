"""Recordings of a planned fleet, a folder for each robot, and the sealed truth."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.fleet.plan import Fault, FleetPlan, PlannedEvent
from drivers.simulated.config import Friction
from drivers.simulated.effect import HiddenEffect
from drivers.simulated.hidden import draw_effect
from drivers.simulated.seal import seal
from recordings.errors import BadInput
from recordings.importing import Description, import_data
from recordings.recording import Floats
from tests.foreign import reference_motion, robots
from tests.foreign.out_of_library import KINDS
from tests.foreign.plant import Plant
from tests.foreign.sizing import EffectSizer

RATE = 250.0
SECONDS, CYCLES = 8.0, 2
SEALED = "truth.sealed.json"
_BITS = 18
_NOISE = 0.01
"""Standard deviation of the voltage's noise [V]."""
_FIRST = datetime(2026, 1, 5, 22, 0, tzinfo=UTC)
FIRST_NIGHT = _FIRST.date()
_UNSET = {"undated": datetime(1970, 1, 1, tzinfo=UTC), "future": datetime(2099, 1, 1, tzinfo=UTC)}
"""Starts of recordings with a clock that nobody had set."""
_VISCOUS, _COULOMB = -0.02, -0.004
"""Relative change of friction with temperature, exponential [1/K]."""
_SCATTER = 0.01
"""Standard deviation by which friction differs from night to night, relative."""
_TRIES = 6


@dataclass(frozen=True, eq=False)
class _FleetRobot:
    """One robot with its two motions and, where something happens to it, the effect at its final size."""

    usual: Plant
    other: Plant
    effect: HiddenEffect | None
    event: PlannedEvent | None


def make(folder: Path, plan: FleetPlan, progress: Callable[[int, int], None] = lambda done, total: None) -> None:
    """Write the recordings of `plan` that `folder` lacks, and the sealed truth."""
    fleet = cache(lambda robot: _robot(plan, robot))
    cells = [(robot, night) for robot in range(plan.robots) for night in range(plan.nights)]
    for done, (robot, night) in enumerate(cells):
        progress(done, len(cells))
        place = folder / name(robot)
        place.mkdir(parents=True, exist_ok=True)
        path = place / f"{(_FIRST + timedelta(days=night)).date()}.mcap"
        if (robot, night) not in plan.missing and not path.exists():
            _record(path, plan, fleet(robot), robot, night)
    if not (folder / SEALED).exists():
        seal(folder / SEALED, truth(plan))


def name(robot: int) -> str:
    """Name of a robot and of its folder."""
    return f"r{robot + 1:02d}"


def truth(plan: FleetPlan) -> dict[str, object]:
    """What happened, as it is sealed."""
    events = [
        {
            **asdict(event),
            "robot": name(event.robot),
            "since": str((_FIRST + timedelta(days=event.night)).date()),
            **_truth_outside(event),
        }
        for event in plan.events
    ]
    broken = [f"{name(robot)}:{night}" for robot, night in sorted(plan.faults)]
    return {"schema": 1, "seed": plan.seed, "nights": plan.nights, "events": events, "broken": broken}


def _robot(plan: FleetPlan, robot: int) -> _FleetRobot:
    rng = np.random.default_rng([plan.seed, robot, 1])
    kind: robots.Kind = ("default", "heavy", "light")[int(rng.integers(3))]
    drawn = robots.draw(kind, rng, rate=RATE, bits=_BITS, reports_command=False)
    shapes: tuple[reference_motion.Shape, ...] = ("stations", "fourier")
    usual, other = (
        Plant(
            drawn,
            reference_motion.draw(drawn.rig.geometry, shape, rng, rate=RATE, seconds=SECONDS, cycles=CYCLES),
        )
        for shape in shapes
    )
    event = next((event for event in plan.events if event.robot == robot), None)
    effect = _effect_of_size(usual, event, rng) if event else None
    return _FleetRobot(usual, other, effect, event)


def _effect_of_size(plant: Plant, event: PlannedEvent, rng: np.random.Generator) -> HiddenEffect:
    sizer = EffectSizer(plant)
    for _ in range(_TRIES):
        outside = event.effect in KINDS
        drawn = _outside(event, rng) if outside else draw_effect(rng, [event.effect], [event.joint])
        sized = sizer.nearest(drawn, event.size)
        if sized and 0.5 < sized[1] / event.size < 1.5:
            return sized[0]
    raise BadInput(f"{event.effect}: a size of {event.size:.3f} on this robot expected, none found; another seed")


def _truth_outside(event: PlannedEvent) -> dict[str, object]:
    """Joints of an effect that no library has, and variables on which it depends."""
    if event.effect not in KINDS:
        return {}
    effect = _outside(event)
    return {"joints": effect.joints, "outside": effect.depends_on()}


def _outside(event: PlannedEvent, rng: np.random.Generator | None = None) -> HiddenEffect:
    """The effect of an event that no library has, with a shape drawn by `rng`."""
    kind = KINDS[event.effect]
    joints = {event.joint, event.joint % 3 + 1} if kind.between_joints else {event.joint}
    return kind.model_validate({"joints": tuple(sorted(joints)), **(kind.draw_shape(rng) if rng else {})})


def _record(path: Path, plan: FleetPlan, robot: _FleetRobot, number: int, night: int) -> None:
    rng = np.random.default_rng([plan.seed, number, night, 2])
    plant = robot.other if (number, night) in plan.other_motion else robot.usual
    celsius = float(plan.temperature[number, night])
    nominal = plant.robot
    effects = []
    if robot.effect and robot.event and (share := robot.event.share(night, plan.nights)):
        effects.append(robot.effect.scaled(share * robot.effect.model_dump()[robot.effect.strength()]))
    plant.robot = replace(nominal, friction=_friction(nominal.friction, celsius, rng))
    reported = plant.report(effects)
    plant.robot = nominal
    fault = plan.faults.get((number, night))
    start = _UNSET.get(fault or "", _start(night, rng) + timedelta(days=plan.clock.get((number, night), 0.0)))
    voltage = reported.voltage + rng.normal(0.0, _NOISE, reported.voltage.shape)
    _write(path, plant, reported.position, voltage, celsius, start, name(number), rng)
    if fault and fault not in _UNSET:
        _break(path, fault, rng)


def _friction(friction: Friction, celsius: float, rng: np.random.Generator) -> Friction:
    def varied(values: tuple[float, ...], slope: float) -> tuple[float, ...]:
        return tuple(
            float(value * np.exp(slope * (celsius - 20.0)) * (1 + rng.normal(0, _SCATTER))) for value in values
        )

    return Friction.model_validate(
        {"viscous": varied(friction.viscous, _VISCOUS), "coulomb": varied(friction.coulomb, _COULOMB)}
    )


def _start(night: int, rng: np.random.Generator) -> datetime:
    return _FIRST + timedelta(days=night, seconds=float(rng.uniform(0, 1800)))


def _write(
    path: Path,
    plant: Plant,
    position: Floats,
    voltage: Floats,
    celsius: float,
    start: datetime,
    robot: str,
    rng: np.random.Generator,
) -> None:
    rig, motion = plant.robot.rig, plant.reference
    per_radian = np.array([drive.counts_per_radian for drive in rig.drives])
    n = len(position)
    warm = celsius + rng.normal(0, 0.1, (n, 3))
    columns = [
        np.arange(n)[:, None] / rig.rate,
        np.rint(position * per_radian) / per_radian,
        voltage,
        np.round(warm, 1),
        motion.repeat[:: motion.per_sample, None],
    ]
    quantities = ("position", "voltage", "temperature")
    header = ["time", *(f"{quantity}_{i}" for quantity in quantities for i in (1, 2, 3)), "cycle"]
    formats = ["%.6f", *["%.9f"] * 3, *["%.5f"] * 3, *["%.1f"] * 3, "%d"]
    table = path.with_suffix(".csv")
    np.savetxt(table, np.hstack(columns), fmt=formats, delimiter=",", header=",".join(header), comments="")
    partial = path.with_suffix(".part.mcap")
    partial.unlink(missing_ok=True)
    text = start.isoformat(timespec="milliseconds")
    import_data(table, partial, Description(rig=rig, simulated=True, start=text, robot=robot))
    table.unlink()
    partial.rename(path)


def _break(path: Path, fault: Fault, rng: np.random.Generator) -> None:
    content = path.read_bytes()
    broken = {
        "truncated": content[: len(content) // 5],
        "random": rng.bytes(20_000),
        "empty": b"",
        "text": b"this is no recording\n" * 100,
    }
    path.write_bytes(broken.get(fault, content))
