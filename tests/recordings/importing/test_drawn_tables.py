"""Drawn tables: what their text decides is read right, everything else is asked for or refused with its place."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from recordings.errors import BadInput
from recordings.importing import Description, Imported, converted
from recordings.importing.proposal import propose
from tests.recordings.importing.drawn_tables import FAULTS, Drawn, draw

AXES = ["--mechanism", "axes"]


def accepted(path: Path) -> Imported:
    """What `daq import --guess --yes` imports; raises BadInput with what it asks for."""
    proposal = propose(path, AXES)
    if proposal.missing:
        raise BadInput("\n".join(proposal.missing))
    words = proposal.arguments
    mapping = [words[k + 1] for k, word in enumerate(words) if word == "--map"]
    return converted(path, Description(mechanism="axes"), mapping)


def wrong(drawn: Drawn, path: Path) -> str:
    """What is wrong about the import of a drawn table; "" if nothing is."""
    path.write_text(drawn.text, encoding="utf-8")
    try:
        samples = accepted(path).samples
    except BadInput as error:
        if not drawn.fault:
            return f"refused: {error}"
        said = FAULTS[drawn.fault] in str(error) and drawn.place in str(error)
        return "" if said else f"{FAULTS[drawn.fault]!r} and {drawn.place!r} expected: {error}"
    if drawn.fault:
        return "imported"
    wrong = [] if np.allclose(samples.stamp / 1e9, drawn.time, atol=1e-6) else ["time"]
    for name, values in drawn.joints.items():
        found = getattr(samples, name)
        if found is None or found.shape != values.shape or not np.allclose(found, values, atol=1e-6, equal_nan=True):
            wrong.append(name)
    return ", ".join(wrong)


@pytest.mark.parametrize(
    "seeds", [range(50), pytest.param(range(50, 500), marks=pytest.mark.slow)], ids=["first", "all"]
)
def test_what_the_text_decides_is_read_and_all_else_asked_for(seeds: range, tmp_path: Path) -> None:
    found = {seed: wrong(draw(seed), tmp_path / f"{seed}.csv") for seed in seeds}
    assert not {seed: f"{draw(seed).fault}: {text}" for seed, text in found.items() if text}


def test_each_fault_and_trait_stands_in_a_tenth() -> None:
    tables = [draw(seed) for seed in range(500)]
    faults = Counter(table.fault for table in tables)
    traits = Counter(trait for table in tables for trait in table.traits)
    assert set(faults) == {"", *FAULTS}
    assert min(faults.values()) >= 0.1 * len(tables)
    assert min(traits.values()) >= 0.1 * len(tables), traits
