import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.bristle import Bristle


@given(speeds=st.lists(st.floats(-20.0, 20.0), max_size=50), reach=st.floats(1e-6, 0.5))
def test_friction_never_exceeds_its_level(speeds: list[float], reach: float) -> None:
    bristle = Bristle(reach)
    assert all(abs(bristle.step(v, 2e-4)) <= 1.0 for v in speeds)


def test_small_displacement_is_elastic_and_large_displacement_slides() -> None:
    bristle = Bristle(0.01)
    assert bristle.step(1.0, 1e-5) == pytest.approx(1e-5 / 0.01, rel=1e-3)
    assert bristle.step(1.0, 0.2) == pytest.approx(1.0)
    bristle.relax()
    assert bristle.step(0.0, 0.2) == 0.0


def test_does_not_depend_on_the_time_step() -> None:
    coarse, fine = Bristle(0.01), Bristle(0.01)
    coarse.step(-0.3, 0.02)
    for _ in range(20):
        fine.step(-0.3, 0.001)
    assert coarse.step(0.0, 1.0) == pytest.approx(fine.step(0.0, 1.0), rel=1e-12)
