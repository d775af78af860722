"""Export to MATLAB: n samples of dof joints as matrices; gaps and quantities that were not measured are NaN.

| variable | content |
|---|---|
| time | (n, 1) from the first sample [s] |
| position, velocity, command | (n, dof) [rad, rad/s; m, m/s for a prismatic joint] |
| voltage, effort | (n, dof) [V; N m, or N for a prismatic joint] |
| statusword, error_code | (n, dof) |
| cycle | (n, 1) repetition of the motion, -1 outside of repetitions |
| lateness | (n, 1) of the host [s] |
| extra, extra_names | (n, k) and their k names: additional columns, as in the topic /extra |
| joint_names, rig, run | names; rig description and run as JSON (`jsondecode`) |
"""

from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np

from recordings.columns import JOINT_COLUMNS
from recordings.reader import read


def write(file: Path, stream: BinaryIO) -> str:
    """See `ExportFormat`."""
    from scipy.io import savemat

    recording = read(file)
    count, gap = len(recording.time), np.full_like(recording.position, np.nan)
    joints = {name: getattr(recording, name) for name in JOINT_COLUMNS}
    savemat(
        cast(Any, stream),  # accepts open files, contrary to its annotations
        {
            "time": recording.time,
            **{name: gap if values is None else values for name, values in joints.items()},
            "statusword": recording.statusword,
            "error_code": recording.error_code,
            "cycle": recording.repeat,
            "lateness": recording.lateness,
            "extra": np.column_stack([np.empty((count, 0)), *recording.extra.values()]),
            "extra_names": np.array(list(recording.extra), object),
            "joint_names": np.array(recording.rig.joint_names, object),
            "rig": recording.rig.model_dump_json(),
            "run": recording.run.model_dump_json(),
        },
        do_compression=True,
        oned_as="column",
    )
    return f"{count} samples"
