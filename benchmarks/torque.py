"""Time of the model at work: the Python API, `ident torque` for an hour of motion, and the C code of an export."""

import re
import subprocess
import tempfile
import timeit
from pathlib import Path

import numpy as np

import ident
from benchmarks.programs import call
from ident.export import exporting, paths
from ident.identification.model import Model, rig_of
from tests.documents import ROOT

STATES = 10_000
SECONDS = 3600
CALLS = 1_000_000
_TIMED = """
#include "delta_model.h"
#include <stdio.h>
#include <time.h>
int main(void) {{
    static delta_model_state state;
    double q[DELTA_MODEL_DOF] = {{0}}, qd[DELTA_MODEL_DOF] = {{0}}, qdd[DELTA_MODEL_DOF] = {{0}};
    double tau[DELTA_MODEL_DOF], sum = 0;
    delta_model_init(&state);
    const clock_t start = clock();
    for (int k = 0; k < {calls}; k++) {{
        q[0] = 1e-7 * k;
        delta_model_torque(&state, q, qd, qdd, 1e-3, tau);
        sum += tau[0];
    }}
    const double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    printf("%.0f ns per call, state %zu bytes (sum %g)", 1e9 * seconds / {calls}, sizeof state, sum);
    return 0;
}}
"""


def api(model: Model) -> None:
    """Time `Model.torque` of random positions, velocities and accelerations after the first call."""
    rng = np.random.default_rng(0)
    q, qd, qdd = (rng.uniform(-limit, limit, (STATES, 3)) for limit in (0.5, 4.0, 60.0))
    model.torque(q, qd, qdd)
    seconds = min(timeit.repeat(lambda: model.torque(q, qd, qdd), number=1, repeat=5))
    print(f"Model.torque: {STATES:,} states in {1e3 * seconds:.1f} ms")


def hour(model_path: Path, folder: Path, rate: int, ending: str) -> None:
    """Time `ident torque` of an hour's path."""
    t = np.arange(SECONDS * rate) / rate
    q = [0.1 + 0.3 * np.sin(3 * t + shift) + 0.1 * np.sin(0.37 * t + shift) for shift in (0.0, 2.1, 4.2)]
    table, out = folder / f"path{rate}.csv", folder / f"torque.{ending}"
    np.savetxt(
        table, np.column_stack([t, *q]), "%.10g", ",", header="time,position_1,position_2,position_3", comments=""
    )
    elapsed = timeit.timeit(lambda: call("ident", "torque", model_path, "--csv", table, "-o", out), number=1)
    print(f"ident torque: an hour at {rate} Hz to {ending} in {elapsed:.1f} s")


def code(model: Model, folder: Path) -> None:
    """Time one call of the C code, and read its stack from the compiler."""
    path = paths.from_trajectory("fig5a", rig_of(model.file), 1)
    exporting.export(model, "c", folder, path)
    (folder / "timed.c").write_text(_TIMED.format(calls=CALLS))
    words = ["cc", "-std=c99", "-O2", "-fstack-usage", "timed.c", "delta_model.c", "-lm", "-o", "timed"]
    subprocess.run(words, cwd=folder, check=True)
    printed = subprocess.run([folder / "timed"], check=True, capture_output=True, text=True).stdout
    usage = "\n".join(file.read_text() for file in folder.glob("*.su"))
    frames = {name: int(size) for name, size in re.findall(r":(\w+)\t(\d+)\t", usage) if name != "main"}
    print(f"C: {printed}; stack at most {sum(frames.values())} bytes")


def main() -> None:
    """Print all times, for a model fitted to the sample recording."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        model = ident.fit([ROOT / "recordings" / "samples" / "fig5a.mcap"], method="lad")
        model.save(folder / "m.json")
        api(model)
        hour(folder / "m.json", folder, 500, "parquet")
        hour(folder / "m.json", folder, 100, "csv")
        code(model, folder)


if __name__ == "__main__":
    main()
