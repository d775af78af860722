"""What was exported as CSV and imported again is what it was."""

from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from daq import exporting
from recordings import blocks
from recordings.blocks import SampleTable
from recordings.imported import imported_rig
from recordings.importing import Description, import_data
from recordings.plausible import LARGEST
from recordings.reader import read
from recordings.recording import Run
from tests.arrays import assert_same
from tests.made_up import run_of

AXES = Description(mechanism="axes")
NUMBERS = st.floats(allow_infinity=False, width=64)


@st.composite
def measurements(draw: st.DrawFn) -> tuple[SampleTable, Run]:
    n, dof = draw(st.integers(2, 12)), draw(st.integers(1, 4))

    def table(quantity: str) -> np.ndarray:
        plausible = st.just(np.nan) | st.floats(-LARGEST[quantity], LARGEST[quantity])
        return draw(arrays(np.float64, (n, dof), elements=plausible))

    steps = draw(arrays(np.int64, n, elements=st.integers(1, 10**10)))
    position = table("position")
    position[draw(st.integers(0, n - 1))] = 0.5
    effort = table("effort") if draw(st.booleans()) else None
    voltage = table("voltage") if effort is None else None
    for known in (effort, voltage):
        if known is not None:
            known[0] = 1.0  # a column without any number is left out
    names = draw(st.lists(st.text(min_size=1, max_size=8).map(str.strip).filter(is_plain), unique=True, max_size=2))
    samples = SampleTable(
        joints=tuple(f"joint_{i + 1}" for i in range(dof)),
        stamp=np.cumsum(steps) - steps[0],
        log=np.arange(n),
        cycle=np.arange(n),
        repeat=np.sort(draw(arrays(np.int64, n, elements=st.integers(-1, 0)))),
        position=position,
        effort=effort,
        voltage=voltage,
        extra={name: draw(arrays(np.float64, n, elements=NUMBERS)) for name in names},
    )
    return samples, run_of(period=draw(st.sampled_from([0.0, 0.5])), cycles=1, rate=100.0)


def is_plain(name: str) -> bool:
    return bool(name) and name.isprintable() and not name.startswith(("time", "cycle", "position", "\ufeff"))


@given(measurements())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=60)
def test_exported_and_imported_arrays_are_equal(tmp_path: Path, samples_and_run: tuple[SampleTable, Run]) -> None:
    samples, run = samples_and_run
    dof = samples.position.shape[1]
    for name in ("a.mcap", "a.csv", "b.mcap"):
        (tmp_path / name).unlink(missing_ok=True)
    blocks.write(tmp_path / "a.mcap", imported_rig("a", dof, 100.0, mechanism="axes"), run, samples)
    exporting.export(tmp_path / "a.mcap", "csv", tmp_path / "a.csv")
    import_data(tmp_path / "a.csv", tmp_path / "b.mcap", AXES)
    original, imported = read(tmp_path / "a.mcap"), read(tmp_path / "b.mcap")
    assert_same(imported, original, "time", "position", "command", "voltage", "effort", "repeat")
    assert list(imported.extra) == list(original.extra)
    assert_same(imported.extra, original.extra, *original.extra)
