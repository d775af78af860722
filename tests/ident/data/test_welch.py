import numpy as np
import pytest
from scipy import signal

from ident.data import welch


@pytest.mark.parametrize("segment", [100, 101])
@pytest.mark.parametrize("centred", [True, False])
def test_densities_are_those_of_scipy(segment: int, centred: bool) -> None:
    rng = np.random.default_rng(3)
    a = 1.0 + rng.normal(size=1030)
    b = np.convolve(a, [0.5, 0.3, 0.2], mode="same")
    transforms = [welch.transforms(x, segment, centred=centred) for x in (a, b)]
    detrend = "constant" if centred else False
    _, common = signal.csd(a, b, 250.0, nperseg=segment, detrend=detrend)
    _, power = signal.welch(a, 250.0, nperseg=segment, detrend=detrend)
    assert welch.density(*transforms, segment, 250.0) == pytest.approx(common.real, rel=1e-9, abs=1e-12)
    assert welch.density(transforms[0], transforms[0], segment, 250.0) == pytest.approx(power, rel=1e-9)
