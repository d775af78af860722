"""Conversion of measurements of other programs to recordings.

A file is read by the format that recognises it (`formats`) into a table (`table`); its columns become quantities in
SI units (`mapping`, `units`, `quantities`), and these a recording. `layout` decides what rows of text say, `clock`
what time is, `columns` what other columns hold; `observations` says what can be seen in the result.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from recordings import blocks
from recordings.blocks import SampleTable
from recordings.columns import columns as columns_of
from recordings.config import validated
from recordings.data_problems import DataProblem
from recordings.errors import BadInput, told
from recordings.imported import imported_rig, measured_torque
from recordings.importing import clock, formats
from recordings.importing.healing import Healing
from recordings.importing.mapping import sources
from recordings.importing.quantities import Quantities, quantities
from recordings.importing.repetitions import mean_step, repetitions
from recordings.importing.table import Table
from recordings.importing.units import RigHints
from recordings.metadata import software
from recordings.plausible import LARGEST, first_implausible
from recordings.reader import is_foreign, read
from recordings.recording import IMPORTED, Floats, Ints, Recording, Run
from recordings.rig import JointType, MechanismName, Rig, Torque
from recordings.urdf import Payload

_MAX_RATE = 4000.0
"""Highest rate that a rig description permits [Hz]."""
_NO_DATE = "1970-01-01T00:00:00.000+00:00"


@dataclass(frozen=True)
class Description:
    """Description of the machine, given in addition to the measurements."""

    rig: Rig | None = None
    mechanism: MechanismName | None = None
    joints: tuple[JointType, ...] = ("revolute",)
    torque: Mapping[str, Any] | None = None
    """Keys of the section [torque] of a rig file; None if they are unknown. A single gain or torque per ampere stands
    for all joints."""
    gravity: bool = False
    """Whether gravity loads the joint of a single axis."""
    payload: Payload | None = None
    """What is mounted; None: as the rig says."""
    simulated: bool = False
    start: str | None = None
    """ISO 8601 time of the first sample; None: as the file says."""
    robot: str | None = None
    """Name of the robot."""
    healing: Healing = field(default_factory=Healing)
    """What is mended of the samples."""

    @property
    def hints(self) -> RigHints:
        """What is known of the joints."""
        return RigHints(self.rig.joint_types, self.rig.drives) if self.rig else RigHints(self.joints)


@dataclass(frozen=True, eq=False)
class Imported:
    """Result of an import."""

    rig: Rig
    run: Run
    samples: SampleTable
    digest: str
    """SHA-256 of the file."""
    notes: tuple[str, ...] = ()
    """Sentences on what was left out, and how the file was read."""
    healed: tuple[DataProblem, ...] = ()
    """Data problems that the import took out itself."""

    def recording(self, path: Path) -> Recording:
        """The recording as it is read from the file `path` that `import_data` writes."""
        samples, none = self.samples, np.full_like(self.samples.position, np.nan)
        words = np.zeros(none.shape, np.uint16)
        return Recording(
            path=path,
            rig=self.rig,
            run=self.run,
            time=samples.stamp / 1e9,
            position=samples.position,
            command=none if samples.command is None else samples.command,
            voltage=none if samples.voltage is None else samples.voltage,
            velocity=samples.velocity,
            effort=samples.effort,
            statusword=words if samples.statusword is None else samples.statusword.astype(np.uint16),
            error_code=words if samples.error_code is None else samples.error_code.astype(np.uint16),
            repeat=samples.repeat,
            lateness=none[:, 0],
            events=(),
            extra=samples.extra,
            known_digest=self.digest,
        )

    @property
    def steps(self) -> Floats:
        """Time steps between the samples (n - 1,) [s]."""
        return np.diff(self.samples.stamp) / 1e9


def import_data(
    path: Path,
    out: Path,
    description: Description,
    mapping: Sequence[str] = (),
    topic: str | None = None,
    names: tuple[str, ...] = (),
) -> Imported:
    """Write the measurements in `path` to the new recording `out`.

    Time is counted from the first sample. Uneven time steps are kept.

    Args:
        mapping: entries NAME=COLUMN:UNIT, or TOML files of such.
        topic, names: as in `formats.read`.

    Raises:
        BadInput: the file violates its format, does not hold what is needed, or contradicts the description, or `out`
            exists.
        OSError: `out` cannot be written; no partial file is left.
    """
    imported = converted(path, description, mapping, topic, names)
    blocks.write(out, imported.rig, imported.run, imported.samples)
    return imported


def converted(
    path: Path,
    description: Description,
    mapping: Sequence[str] = (),
    topic: str | None = None,
    names: tuple[str, ...] = (),
) -> Imported:
    """Convert the measurements in `path`, as `import_data`, without writing a file."""
    if is_ours(path):
        return _healed(path, description, mapping)
    return of_table(formats.read(path, topic, names), description, mapping)


def of_table(table: Table, description: Description, mapping: Sequence[str] = ()) -> Imported:
    """Convert the measurements in `table`, as `import_data`."""
    columns = sources(table, mapping)
    time = clock.read(table, columns.get("time"))
    table = time.table
    values = quantities(table, columns, description.hints)
    rate = 1e9 / mean_step(time.stamp)
    rig = _rig(table, description, values.joints, rate)
    rig = rig.model_copy(update={"payload": description.payload}) if description.payload else rig
    joints = dict(values.joints)
    if not {"voltage", "effort"} & joints.keys():
        joints["effort"] = _effort(table, joints["current"], rig)
    repeat, period = repetitions(table, values.cycle, time.stamp, joints.get("command", joints["position"]))
    run = Run(
        trajectory=IMPORTED,
        trajectory_digest=table.digest,
        period=period,
        cycles=max(int(repeat.max()) + 1, 1),
        rate=rate,
        software=software(),
        simulated=description.simulated,
        pace="realtime",
        start=description.start or _start(time),
        robot=description.robot,
        exit_status=0,
        reason=f"imported from {table.path.name}",
    )
    samples = description.healing.of(_samples(rig, time, values, joints, repeat))
    used = {column for source in columns.values() for column in source.columns}
    unread = ", ".join(name for name in table.unreadable if name not in used)
    notes = (*table.notes, *([f"left out, because not finite numbers throughout: {unread}"] if unread else []))
    return Imported(rig, _run(run, description, samples), samples, table.digest, notes, time.problems)


def is_ours(path: Path) -> bool:
    """Whether `path` is a recording of ours: MCAP with the description of a rig."""
    try:
        return path.suffix == ".mcap" and not is_foreign(path)
    except BadInput:
        return False


def _healed(path: Path, description: Description, mapping: Sequence[str]) -> Imported:
    """Convert our own recording `path` anew: other columns or units, mended samples; rig, run and gaps are kept."""
    recording = read(path)
    table = Table(path, columns_of(recording), digest=recording.digest)
    rig = description.rig or recording.rig
    columns = sources(table, mapping)
    time = clock.read(table, columns.get("time"))
    values = quantities(table, columns, RigHints(rig.joint_types, rig.drives))
    _rig(table, replace(description, rig=rig), values.joints, recording.run.rate)  # the number of joints is right
    of_drives = {name: getattr(recording, name).astype(np.int64) for name in ("statusword", "error_code")}
    samples = description.healing.of(
        replace(_samples(rig, time, values, values.joints, recording.repeat), **of_drives)
    )
    note = f"{path.name}: rig, run and gaps are kept, bus frames and events are not"
    return Imported(rig, _run(recording.run, description, samples), samples, table.digest, (note,))


def _samples(
    rig: Rig, time: clock.Clock, values: Quantities, joints: Mapping[str, Floats], repeat: Ints
) -> SampleTable:
    """The samples of `joints`, (n, dof) by quantity."""
    return SampleTable(
        joints=rig.joint_names,
        stamp=time.stamp,
        log=time.stamp,
        cycle=np.arange(len(time.stamp)),
        repeat=repeat,
        extra=values.extra,
        position=joints["position"],
        command=joints.get("command"),
        voltage=joints.get("voltage"),
        velocity=joints.get("velocity"),
        effort=joints.get("effort"),
    )


def _run(run: Run, description: Description, samples: SampleTable) -> Run:
    """The `run` of mended `samples`; of thinned ones each still holds the torque of one sample before."""
    thin, trim = description.healing.thin, description.healing.trim
    if trim:
        start = datetime.fromisoformat(run.start) + timedelta(seconds=max(trim.start, 0.0))
        cycles = max(int(samples.repeat.max()) + 1, 1)
        run = run.model_copy(update={"cycles": cycles, "start": start.isoformat(timespec="milliseconds")})
    if thin == 1:
        return run
    return run.model_copy(update={"rate": run.rate / thin, "torque_window": run.torque_window or 1 / run.rate})


def _start(time: clock.Clock) -> str:
    """ISO 8601 time of the first sample as the file says it; 1970 where it does not."""
    if time.epoch is not None:
        return datetime.fromtimestamp(time.epoch, UTC).isoformat(timespec="milliseconds")
    return time.table.start or _NO_DATE


def _effort(table: Table, current: Floats, rig: Rig) -> Floats:
    """Effort (n, dof) [N m or N] of the `current` (n, dof) [A]."""
    if not rig.torque.per_ampere:
        raise BadInput(
            f"{table.path} holds currents: their torque per ampere expected, none found; give "
            f"{told('--kt, or ', '')}torque.per_ampere in the rig file"
        )
    effort: Floats = current * np.array(rig.torque.per_ampere)
    if wrong := first_implausible(effort, "effort"):
        raise BadInput(
            f"{table.location(wrong[0])}: effort within ±{LARGEST['effort']:g} N m or N expected, {effort[wrong]:g} "
            f"found for joint {wrong[1] + 1}; correct its torque per ampere"
        )
    return effort


def _for_joints(torque: Mapping[str, Any], dof: int) -> dict[str, Any]:
    """Keys of [torque] with a gain and torque per ampere for each joint; a gain that is given is a calibrated one."""
    content = dict(torque)
    for name, option in (("gain", "--gain"), ("per_ampere", "--kt")):
        if name in content:
            if len(content[name]) not in (1, dof):
                raise BadInput(
                    f"{option}: one number, or {dof} (one per joint) expected, {len(content[name])} found; correct it"
                )
            content[name] = content[name] * (dof // len(content[name]))
    return content | ({"gain_source": "calibrated"} if "gain" in content else {})


def _rig(table: Table, description: Description, joints: Mapping[str, Floats], rate: float) -> Rig:
    dof, volts = joints["position"].shape[1], "voltage" in joints
    if description.rig is not None:
        if description.rig.dof != dof:
            raise BadInput(
                f"{table.path}: {description.rig.dof} joints expected by the rig file, {dof} columns position_i "
                f"found; {told('choose as many with --names, or ', '')}map them, or choose another rig file"
            )
        return description.rig
    if not volts and {"map", "gain"} & (description.torque or {}).keys():
        raise BadInput(f"{table.path} holds no voltages, which alone need a torque map or gain; leave these out")
    if "effort" in joints and "per_ampere" in (description.torque or {}):
        raise BadInput(f"{table.path} holds efforts, which need no torque per ampere; leave --kt out")
    if dof != 3 and description.mechanism is None:
        names = told("choose three with --names A,B,C (1,2,3 of position_1 ...)", "leave the others out")
        found = f"{dof} found" + (f" ({'; '.join(table.notes)})" if table.notes else "")
        raise BadInput(
            f"{table.path}: the three joints of a delta robot expected, {found}; say what it is with "
            f"{told('--rig, or with --mechanism axes --joints revolute|prismatic', 'rig')}, or "
            f"{names if dof > 3 else 'map three'}"
        )
    given = validated(_for_joints(description.torque or {}, dof), Torque, "--torque-map, --gain, --kt")
    return imported_rig(
        table.path.stem,
        dof,
        min(rate, _MAX_RATE),
        mechanism=description.mechanism,
        joints=description.joints,
        torque=given if volts else measured_torque(dof, given.per_ampere),
        gravity=description.gravity,
    )
