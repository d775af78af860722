"""Test the noise floor of recordings in which nothing repeats, on foreign robots.

`python -m benchmarks.noise_floor --cases 60 --jobs 1`: in a third of the cases nothing is hidden, in a third one
effect of 3 %, in a third two effects. The last are not searched: the floor is that below a wrong model. Each
robot is recorded twice, as it is and by perfect sensors. What these two residuals of the same model differ by is the
true noise. Results are kept in runs/noise_floor; a second run continues there.
"""

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks.hidden_effects import foreign, scoring
from benchmarks.hidden_effects.cases import HiddenCase, Kind
from benchmarks.hidden_effects.diagnosing import engine
from benchmarks.hidden_effects.drawn_cases import drawn_cases
from benchmarks.hidden_effects.work import Answers
from ident.diagnosis.judge.fitted_model import FittedModel
from recordings.errors import BadInput
from tests.foreign.pairs import TRAIN, VALIDATE

KINDS: tuple[Kind, ...] = ("nothing", "single", "pair")
SIZE = 0.03
"""Of the hidden effect of a `single` case."""
PERFECT_BITS = 28
"""Resolution of perfect encoders [bit]."""
ROOT = Path("runs/noise_floor")


@dataclass(frozen=True)
class Row:
    """Result of one case."""

    kind: Kind
    held: tuple[bool, ...]
    """Whether the interval of each joint holds the true noise."""
    right: bool
    """Whether nothing hidden is adequate, or the effect is named first."""


def main() -> None:
    """Diagnose the cases that are not stored yet, and print the figures of all of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    version, cases = engine(), drawn(options.cases)
    lines = Answers(ROOT).completed(version, cases, partial(examine, version=version), options.jobs, summary)
    report([row_of(case, lines[case.name]) for case in cases if "impossible" not in lines[case.name]])


def drawn(count: int) -> list[HiddenCase]:
    """As many cases of each kind, which nothing was tuned on; their order is that of their kinds in turn."""
    cases = [
        replace(case, repeats=False)
        for case in drawn_cases("locked", "noise floor")
        if case.kind != "single" or case.sizes == (SIZE,)
    ]
    by_kind = [[case for case in cases if case.kind == kind] for kind in KINDS]
    return list(chain(*zip(*by_kind, strict=False)))[:count]


def examine(case: HiddenCase, version: str) -> dict[str, Any]:
    """Record and diagnose a case; return the line to store, or why its robot cannot have the effect."""
    from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
    from ident.diagnosis.document.verdict import to_document
    from ident.dynamics.effects.library import library

    perfect_case = replace(case, volts=0.0, bits=PERFECT_BITS, signal_bits=None)
    with TemporaryDirectory() as name:
        measured, perfect = Path(name, "measured"), Path(name, "perfect")
        try:
            for folder, each in ((measured, case), (perfect, perfect_case)):
                folder.mkdir()
                truth = foreign.record(each, folder)
        except BadInput as error:
            return {"case": case.name, "engine": version, "impossible": str(error)}
        effects = library()
        left_out = tuple(name for name, effect in effects.items() if case.kind == "pair" and not effect.mandatory)
        files = [measured / TRAIN], [measured / VALIDATE]
        diagnosis = diagnose(*files, effects, DiagnosisOptions(without=left_out))
        noise = true_noise(diagnosis.model, [perfect / TRAIN, perfect / VALIDATE])
    floor = diagnosis.model.noise_floor
    return {
        "case": case.name,
        "engine": version,
        "truth": truth,
        "noise": noise.tolist(),
        "torque_noise": floor.noise.tolist(),
        "quantization": floor.quantization.tolist(),
        "ci95": floor.ci95.tolist(),
        "source": floor.source,
        "document": json.loads(json.dumps(to_document(diagnosis).as_json())),
    }


def true_noise(model: FittedModel, perfect: Sequence[Path]) -> np.ndarray:
    """(dof,) RMS of what the residuals of a model differ by from those on `perfect` recordings [N m]."""
    from ident.data.prepared_recording import prepare
    from ident.diagnosis.split.split_data import rms
    from ident.estimation.predicted_torque import TorquePredictor
    from recordings.reader import read

    differences = []
    for path, recording, residual in zip(perfect, model.split.recordings, model.residuals, strict=True):
        exact = prepare(read(path), recording.method, recording.cutoff)
        torque = TorquePredictor(exact).torque(model.solution.structure, model.solution.x)
        differences.append(residual - (exact.torque - torque))
    return rms(differences, model.split.scored)


def row_of(case: HiddenCase, line: dict[str, Any]) -> Row:
    """The result of a case from its stored line."""
    pairs = zip(line["noise"], line["ci95"], strict=True)
    return Row(
        case.kind,
        tuple(low <= noise <= high for noise, (low, high) in pairs),
        case.kind != "pair" and scoring.judge(case, line["truth"], {"seconds": 0.0, **line}).right,
    )


def summary(line: dict[str, Any]) -> str:
    """Short text of a stored line."""
    if "impossible" in line:
        return str(line["impossible"])
    ratio = np.round(np.array(line["ci95"]) / np.array(line["noise"])[:, None], 2).tolist()
    findings = [finding["effect"] for finding in line["document"]["findings"]]
    return f"interval / true noise {ratio}, {line['document']['verdict']}, {', '.join(findings) or 'nothing'}"


def report(rows: Sequence[Row]) -> None:
    """Print the figures of acceptance."""
    joints = list(chain.from_iterable(row.held for row in rows))
    print(
        f"noise_ci95 holds the true noise of all joints in {sum(all(row.held) for row in rows)} of {len(rows)} cases"
    )
    print(f"and of {sum(joints)} of {len(joints)} joints")
    for kind, what in (("nothing", "nothing hidden is adequate"), ("single", "the hidden effect is named first")):
        right = [row.right for row in rows if row.kind == kind]
        print(f"{what} in {sum(right)} of {len(right)} cases")


if __name__ == "__main__":
    main()
