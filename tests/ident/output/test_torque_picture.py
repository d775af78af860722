"""The picture of the torque by its causes."""

from pathlib import Path

import numpy as np
import pytest

from ident.output import torque_picture


@pytest.mark.parametrize("with_intervals", [True, False])
def test_every_joint_and_cause_is_drawn(
    with_intervals: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from matplotlib.axes import Axes

    bars: list[list[str]] = []
    original = Axes.barh
    monkeypatch.setattr(
        Axes, "barh", lambda self, y, *rest, **options: bars.append(list(y)) or original(self, y, *rest, **options)
    )
    time = np.arange(50) / 10
    terms = {"gravity": np.outer(np.cos(time), [1.0, -2.0]), "coulomb": np.outer(np.sign(np.sin(time)), [1.0, 1.0])}
    rms = {name: np.sqrt((values**2).mean(axis=0)) for name, values in terms.items()}
    widths = {name: np.array([0.1, np.nan]) for name in terms} if with_intervals else None
    out = tmp_path / "a.part"
    torque_picture.draw(out, "a path", time, np.sum(list(terms.values()), axis=0), terms, rms, widths, ("N m", "N"))
    assert bars == [["gravity", "coulomb"]] * 2
    assert out.read_bytes().startswith(b"\x89PNG")
