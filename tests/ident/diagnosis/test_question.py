"""What a diagnosis begins with: which recordings, at which cut-off."""

import numpy as np

from ident.diagnosis.diagnosis import MAX_TORQUE_LOSS, _band_share


def test_a_low_pass_that_takes_ripple_away_takes_much_of_the_torque() -> None:
    time = np.arange(0.0, 5.0, 1e-3)[:, None]
    swaying = np.sin(2 * np.pi * time) + 0.3 * np.sign(np.sin(2 * np.pi * time))
    ripple = 0.3 * np.sin(2 * np.pi * 70.0 * time)
    assert _band_share(swaying, 1000.0, 23.0, 78.0) < MAX_TORQUE_LOSS / 2
    assert _band_share(swaying + ripple, 1000.0, 23.0, 78.0) > MAX_TORQUE_LOSS
    assert _band_share(swaying + ripple, 1000.0, 78.0, 78.0) == 0.0
