"""The commented rig file of a proposal."""

import json
import math
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from daq.proposal.choices import USUAL_RATE, TorqueSource, common_torque_source, mode_of, rates_of
from daq.proposal.drive_section import DriveSection, with_placeholders
from daq.proposal.facts import DriveFacts
from daq.proposal.text import ASK, ASSUMED, LEGEND, PHYSICS, STATED, UNKNOWN, Key, comment
from drivers.canopen.pdo import bus_load
from recordings.buses import CanBus
from recordings.config import validated
from recordings.errors import BadInput, printable
from recordings.rig import Limits, Rig

_LARGEST_LOAD = 0.9
"""Bus load above which no rig file is proposed."""


@dataclass(frozen=True)
class RigProposal:
    """A rig file, and what its user must know and decide."""

    text: str
    notes: tuple[str, ...]
    rig: Rig
    """With placeholders for what the text asks."""

    @property
    def asks(self) -> bool:
        """Whether a value that is in use is one that nothing says."""
        content = tomllib.loads(self.text)
        return bool(with_placeholders(content) != content)


def propose(drives: Sequence[DriveFacts], bus: CanBus, source: TorqueSource | None = None) -> RigProposal:
    """Propose a rig file for these drives, one per joint; `source`: of the torque, None: the best that all have.

    Raises:
        BadInput: a drive cannot be driven by this program, with the reason.
    """
    for facts in drives:
        mode_of(facts)  # a drive that cannot move needs no torque
    source, rates = source or common_torque_source(drives), rates_of(drives)
    drafts = [_proposal(drives, bus, source, rate, rates, draft=None).rig for rate in rates]
    fitting = [draft for draft in drafts if bus_load(draft, draft.rate) <= bus.max_load]
    draft = fitting[0] if fitting else min(drafts, key=lambda each: each.rate)
    return _proposal(drives, bus, source, draft.rate, rates, draft)


def _proposal(
    drives: Sequence[DriveFacts],
    bus: CanBus,
    source: TorqueSource,
    rate: float,
    rates: Sequence[float],
    draft: Rig | None,
) -> RigProposal:
    """A proposal; with a `draft` it accounts for what the drives would be written and for the load of the bus.

    `rates`: those that the drives accept [Hz].
    """
    notes: list[str] = []
    sections = [DriveSection(joint, facts, source) for joint, facts in enumerate(drives, start=1)]
    lines = [*_head(drives, rate, rates), *_bus(bus, drives, draft), *_torque(sections, source), *_limits()]
    explained: set[tuple[str, int]] = set()
    for section in sections:
        kind = section.origin, section.axis
        lines += section.lines(draft, explain=kind not in explained)
        explained.add(kind)
        notes += section.notes
    text = "".join(f"{printable(line)}\n" for line in lines)
    content = with_placeholders(tomllib.loads(text))
    return RigProposal(text, tuple(dict.fromkeys(notes)), validated(content, Rig, "proposal"))


def _head(drives: Sequence[DriveFacts], rate: float, rates: Sequence[float]) -> Iterator[str]:
    origins = ", ".join(dict.fromkeys(facts.origin for facts in drives))
    values = ", ".join(dict.fromkeys(facts.values for facts in drives))
    yield from comment(f"Rig file proposed by `daq rig propose` from {origins}; values: {values}.")
    yield from comment("Each value says where it comes from:")
    for mark, meaning in LEGEND.items():
        yield from comment(f"- {mark}{meaning}.")
    yield from comment("Next: daq check --rig FILE, which moves nothing; then docs/how-to/real-drives.md.")
    yield ""
    yield from Key("name", '"proposed rig"').lines()
    if len(drives) != 3:
        yield from Key("mechanism", '"axes"', PHYSICS + "a delta robot has three drives").lines()
    reason = f"{STATED}Hz; 60C2h accepts no period of 2 ms"
    if USUAL_RATE in rates:
        is_usual = rate == USUAL_RATE
        reason = f"{ASSUMED}Hz; the usual rate, which 60C2h does not exclude"
        reason = reason if is_usual else f"{PHYSICS}Hz; at {USUAL_RATE:g} Hz a cycle does not fit into the bit rate"
    yield from Key("rate", f"{rate:g}.0", reason).lines()
    if len(drives) != 3:
        for _ in drives:
            yield from ("", "[[axes]]")
            yield from Key("type", '"revolute"', ASSUMED + "or prismatic").lines()
            yield from Key("gravity", "true", "uncomment for an axis that lifts a weight", False).lines()


def _bus(bus: CanBus, drives: Sequence[DriveFacts], draft: Rig | None) -> Iterator[str]:
    yield from ("", "[bus]")
    yield from Key("interface", f'"{bus.interface}"').lines()
    yield from Key("channel", f'"{bus.channel}"').lines()
    if bus.interface == "udp_multicast":
        yield from Key("port", str(bus.udp_port)).lines()
    if bus.options:
        options = ", ".join(f"{key} = {json.dumps(value)}" for key, value in bus.options.items())
        yield from Key("options", f"{{ {options} }}").lines()
    allowed = [facts.bit_rates for facts in drives if facts.bit_rates]
    common = frozenset.intersection(*allowed) if allowed else frozenset()
    rate = bus.bitrate if not common or bus.bitrate in common else max(common)
    origin = STATED if common else ASSUMED
    yield from Key("bitrate", str(rate), origin + "bit/s; that of all nodes on this bus").lines()
    load = 0.0 if draft is None else bus_load(draft, draft.rate)
    if draft is not None and load > bus.max_load:
        if load > _LARGEST_LOAD:
            raise BadInput(
                f"at {draft.rate:g} Hz, the slowest rate of these drives, a cycle takes up to {load:.0%} of the bus "
                f"at {rate / 1000:g} kbit/s; choose a higher bit rate, or a bus for each drive"
            )
        text = f"{PHYSICS}a cycle takes up to {load:.1%} of the bus at the only rate that the drives accept"
        yield from Key("max_load", f"{math.ceil(100 * load) / 100:g}", text).lines()


def _limits() -> Iterator[str]:
    limits = Limits()
    yield from ("", "[limits]")
    yield from comment(
        f"{ASSUMED}these belong to the machine, not to the drives: here are those of the simulated robot. The drives "
        "get the joint limits (607Dh), the following error (6065h) and the quick stop's acceleration (6085h) in "
        "their own units; daq check shows them."
    )
    for name, unit in (
        ("joint_min", "rad"),
        ("joint_max", "rad"),
        ("speed", "rad/s"),
        ("acceleration", "rad/s^2"),
        ("torque", "N m"),
        ("following_error", "rad"),
    ):
        yield from Key(name, str(float(getattr(limits, name))), unit).lines()


def _torque(sections: "Sequence[DriveSection]", source: TorqueSource) -> Iterator[str]:
    if source == "none":
        return
    yield from ("", "[torque]")
    if source == "voltage":
        yield from comment(
            'torque = gain * v * |v| ("square") or gain * v ("linear"). No drive states the gain: with 1.0, '
            "parameters are known up to one common factor; `ident calibrate-gain` finds it from a known payload."
        )
        text = ASSUMED + "linear where the voltage is proportional to the torque"
        yield from Key("map", '"square"', text).lines()
    elif source == "torque_actual":
        yield from comment(
            "torque = 6077h / 1000 * rated_torque: linear, in N m at the joint. The gain is rated_torque of each "
            "drive, a rating and no calibration; `ident calibrate-gain` compares it with a known payload."
        )
        yield from Key("map", '"linear"', PHYSICS + "6077h is a torque").lines()
    else:
        gains = [section.torque_per_ampere() for section in sections]
        yield from comment(
            "torque = 6078h / 1000 * rated_current * per_ampere: linear, in N m at the joint. The gain is "
            "per_ampere, the motor's torque constant times the gear; `ident calibrate-gain` checks it with a payload."
        )
        yield from Key("map", '"linear"', PHYSICS + "torque is proportional to the current").lines()
        values = ", ".join(f'"{ASK}"' if gain is None else f"{gain:.6g}" for gain, _ in gains)
        mark = UNKNOWN if any(gain is None for gain, _ in gains) else STATED
        origins = "; ".join(dict.fromkeys(why for _, why in gains))
        yield from Key("per_ampere", f"[{values}]", f"{mark}N m/A; {origins}").lines()
    yield from Key("gain_source", '"assumed"', ASSUMED + "until a payload calibrates it").lines()
