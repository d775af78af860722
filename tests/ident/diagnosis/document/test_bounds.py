"""No parameter is outside of its bounds without a caution."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.diagnosis.document.document import ParameterValue
from ident.diagnosis.document.verdict import to_document
from ident.diagnosis.document.warnings import bound_warnings
from ident.dynamics.effects.library import library
from ident.dynamics.structure import ModelStructure, Term
from recordings.recording import Recording
from tests.ident import building

LIBRARY = {name: effect for name, effect in library().items() if "axes" in effect.mechanisms}
ENTRIES = ModelStructure(
    building.structure(building.record()).mechanism,
    building.bench(),
    tuple(Term.on_all_joints(name, effect, building.bench()) for name, effect in LIBRARY.items()),
).parameters
"""The parameters of one joint with every effect of the library."""
USUAL = {entry.name: entry.usual for entry in ENTRIES}
SIZES = st.floats(-1e3, 1e3)


def drawn(seed: int) -> dict[str, ParameterValue]:
    """Values and intervals, many of the values at a bound."""
    generator, values = np.random.default_rng(seed), {}
    for entry in ENTRIES:
        limits = [limit for limit in (entry.lower, entry.upper, *entry.usual) if np.isfinite(limit)]
        value, width = float(generator.choice([*limits, *generator.normal(0, 10, 3)])), generator.exponential(5)
        values[entry.name] = ParameterValue(
            value=value,
            unit=entry.unit,
            ci95=(value - width, value + width) if generator.random() < 0.8 else None,
            meaning=entry.meaning,
            lower=entry.lower if np.isfinite(entry.lower) else None,
            upper=entry.upper if np.isfinite(entry.upper) else None,
        )
    return values


def is_outside(parameter: ParameterValue) -> bool:
    below = parameter.lower is not None and parameter.value < parameter.lower
    return below or (parameter.upper is not None and parameter.value > parameter.upper)


@given(st.integers(0, 2**32))
def test_every_parameter_outside_of_its_bounds_is_named_with_value_and_interval(seed: int) -> None:
    values = drawn(seed)
    texts = list(bound_warnings(values, USUAL))
    for name, parameter in values.items():
        low, high = USUAL[name]
        named = [text for text in texts if f"{name} = {parameter.in_words} is " in text]
        if is_outside(parameter):
            assert len(named) == 1
            bound = parameter.lower if parameter.value < (parameter.lower or 0.0) else parameter.upper
            interval = parameter.interval
            sure = interval is not None and bound is not None and not interval[0] <= bound <= interval[1]
            assert named[0].startswith("Impossible: ") is sure
        elif not low < parameter.value < high:
            assert len(named) == 1
            assert named[0].startswith("Unusual: ")
        else:
            assert not named


def test_document_of_a_reversed_torque_names_every_impossible_parameter(
    write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    recording = building.record(noise=0.05)
    assert recording.effort is not None
    for sign in (1.0, -1.0):
        file = write(replace(recording, effort=sign * recording.effort, path=tmp_path / f"{sign}.mcap"))
        document = to_document(diagnose([file], [], {}, DiagnosisOptions()))
        outside = {name: value for name, value in document.steps[-1].parameters.items() if is_outside(value)}
        assert set(outside) == ({"I_1", "c_v1", "c_c1"} if sign < 0 else set())
        for name, value in outside.items():
            (text,) = (text for text in document.warnings if f"{name} = {value.in_words} is below 0" in text)
            assert "the sign of a torque or an angle is reversed" in text


def test_presliding_over_ten_degrees_is_unusual() -> None:
    entry = next(entry for entry in ENTRIES if entry.name == "presliding_hysteresis.z_s")
    wide = ParameterValue(
        value=0.17, unit=entry.unit, ci95=(0.16, 0.18), meaning="", lower=entry.lower, upper=entry.upper
    )
    (text,) = bound_warnings({entry.name: wide}, USUAL)
    assert text.startswith("Unusual: presliding_hysteresis.z_s = 0.17 (0.16 to 0.18) rad is at least 0.05")
