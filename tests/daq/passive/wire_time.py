"""Three drives on one serial line in exact simulated time, as in real time on a host that is never late."""

from collections.abc import Generator
from functools import partial
from typing import Any

import numpy as np

from drivers.protocol import Goal, Power
from drivers.serial.axis import SerialAxis
from drivers.serial.protocol import Reply, parse
from drivers.simulated.config import SimConfig
from drivers.simulated.machine import Machine
from drivers.simulated.serial_drive import SimulatedSerialDrive
from drivers.simulated.service import advance_machine
from recordings.blocks import SampleTable
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import Trajectory, approach

_REACTION = 0.0002
"""Delay of a reply after its command plus delay of the next command after the reply [s]."""


class OneLine:
    """Simulated recording over one line: moves the drives and stores their answers and measurement times."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._machine = machine = Machine(rig, SimConfig(), np.random.default_rng(0))
        self._drives = [
            SimulatedSerialDrive(
                rig, j + 1, machine.dt, partial(self._counts, j), partial(self._voltage, j), lockstep=False
            )
            for j in range(rig.dof)
        ]
        self._axes = [SerialAxis(rig, j + 1) for j in range(rig.dof)]
        self._now = 0.0
        names = rig.serial.registers
        self._position_at, self._voltage_at = [0.0] * rig.dof, [0.0] * rig.dof
        self._measured = {f"g {names.position}": self._position_at, f"g {names.voltage}": self._voltage_at}
        self._rows: list[dict[str, Any]] = []
        for j, axis in enumerate(self._axes):
            self._exchange(j, axis.configure())
        self._first = int(self._now * rig.rate) + 1

    def run(self, trajectory: Trajectory) -> SampleTable:
        """Follow `trajectory`; return the samples with the delays of their values."""
        while not all(axis.power is Power.ON for axis in self._axes):
            self._cycle(None, -1)
        start = np.array(self._rows[-1]["position"])
        for target in approach(start, trajectory.joint_position[0], self._rig.limits, self._rig.rate):
            self._cycle(target, -1)
        for target, repeat in zip(trajectory.joint_position, trajectory.repeat.tolist(), strict=True):
            self._cycle(target, repeat)
        table = {name: np.array([row[name] for row in self._rows]) for name in self._rows[0]}
        stamp = np.rint(np.arange(len(self._rows)) * 1e9 / self._rig.rate).astype(np.int64)
        return SampleTable(
            joints=self._rig.joint_names,
            stamp=stamp,
            log=stamp,
            cycle=np.arange(len(stamp)),
            repeat=table["repeat"],
            position=table["position"],
            voltage=table["voltage"],
            extra={
                f"{name}_{j + 1}": table[name][:, j]
                for name in ("position_delay", "voltage_delay")
                for j in range(self._rig.dof)
            },
        )

    def _cycle(self, target: Floats | None, repeat: int) -> None:
        begin = (self._first + len(self._rows)) / self._rig.rate
        assert self._now <= begin
        self._advance(begin)
        for j, axis in enumerate(self._axes):
            axis.begin_cycle()
            drive = axis.drive
            counts = None if target is None else round((target[j] - drive.zero_offset) * drive.counts_per_radian)
            command = None if counts is None else axis.target(counts)
            self._exchange(j, axis.cycle(Goal.ENABLED, command, read_status=j == len(self._rows) % len(self._axes)))
        self._rows.append(
            {
                "repeat": repeat,
                "position": [axis.position for axis in self._axes],
                "voltage": [axis.voltage for axis in self._axes],
                "position_delay": np.array(self._position_at) - begin,
                "voltage_delay": np.array(self._voltage_at) - begin,
            }
        )

    def _exchange(self, j: int, script: Generator[str, Reply, None]) -> None:
        """Exchange commands and replies with drive `j`; each character takes its transmission time."""
        drive, character = self._drives[j], self._rig.serial.character
        reply: Reply | None = None
        while True:
            try:
                command = next(script) if reply is None else script.send(reply)
            except StopIteration:
                return
            self._advance(self._now + (len(command) + 1) * character)
            request = command.removeprefix(drive.prefix)
            text = drive.handle(request, self._machine.time)
            if request in self._measured:
                self._measured[request][j] = self._machine.time
            self._now += _REACTION + (len(text) + 1) * character
            reply = parse(text.encode())

    def _advance(self, time: float) -> None:
        self._now = time
        if time > self._machine.time and advance_machine(self._machine, self._drives, time - self._machine.time):
            for drive in self._drives:
                drive.update(self._machine.time)

    def _counts(self, j: int) -> int:
        return self._machine.encoder_counts()[j]

    def _voltage(self, j: int) -> int:
        return self._machine.voltage_counts()[j]
