"""Compare the swarm over nonlinear parameters with nonlinear least squares: what they find, and what it costs.

Each case is a pair of recordings of the simulated rig with one hidden effect. Both searches know which. Afterwards,
both compute the linear parameters in the same way, as the certified minimum of (33).
"""

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import ident
from benchmarks import programs
from benchmarks.programs import claim
from ident import Model


@dataclass(frozen=True)
class HiddenShape:
    """A hidden effect."""

    title: str
    effect: str
    """Name of the effect, in the plant and in the model."""
    parameters: str
    """Its true parameters, as TOML."""
    truth: str


CASES = (
    HiddenShape("Stribeck speed", "stribeck", "a = 2.0, v_s = 0.3", "v_s = 0.3"),
    HiddenShape("length L2", "geometry_error", "error = 0.02, L2 = 1.0", "e = 0.02"),
    HiddenShape("three zero offsets", "encoder_zero_offset", "c = 0.1", "c = 0.1"),
    HiddenShape("cogging", "cogging", "a = 0.4, N = 42.0", "N = 42"),
)
SEARCHES = {"least squares": "lad", "swarm": "pso_nonlinear"}
"""Method of `ident fit` by search."""


def record(folder: Path, case: HiddenShape) -> list[Path]:
    """Record the motions fig5a and fig5b of a robot with the hidden effect of `case`."""
    sim = folder / f"{case.effect}.toml"
    sim.write_text(f'effects = [{{ name = "{case.effect}", parameters = {{ {case.parameters} }} }}]\n')
    options = ["--cycles", 2, "--rate", 250, "--sim", sim]
    return [
        programs.record(folder / f"{case.effect}_{trajectory}.mcap", trajectory, *options)
        for trajectory in ("fig5a", "fig5b")
    ]


def row(case: HiddenShape, search: str, model: Model, seconds: float) -> str:
    """One line of the table."""
    fitted = model.file
    assert fitted.validate_ is not None
    values = ", ".join(
        f"{parameter.name.partition('.')[2]} = {parameter.value:.4g}"
        for parameter in fitted.searched
        if parameter.lower < parameter.upper
    )
    rms = sum(fitted.validate_.fitted.rms) / len(fitted.validate_.fitted.rms)
    evaluations = fitted.method.diagnostics.get("evaluations", "")
    result = f"{fitted.method.objective:8.1f} {rms:8.4f} {evaluations:>7} {seconds:6.1f}"
    return f"{case.title:18} {search:13} {result}  {values}"


def main(cases: Sequence[HiddenShape] = CASES) -> None:
    """Print (33) on the training data, the held-out error, the cost and the parameters of each case and search."""
    print("nonlinear parameters: (33) [N m], held-out RMS [N m], models tried, processor time of the fit [s], found")
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for case in cases:
            train, validation = record(Path(folder), case)
            ends = []
            for search, method in SEARCHES.items():
                start = time.process_time()
                model = ident.fit([train], validate=validation, method=method, effects=[case.effect])
                ends.append(model.file.method.objective)
                print(row(case, search, model, time.process_time() - start), flush=True)
            worst = max(worst, ends[1] / ends[0] - 1)
            print(f"{'':18} {'truth':13} {'':39} {case.truth}", flush=True)
    claim("the swarm ends at most 1 % above nonlinear least squares", worst <= 0.01)


if __name__ == "__main__":
    main()
