"""An effect of your own: one file with a formula, which a diagnosis tries beside the library."""

import matplotlib.pyplot as plt
import numpy as np

import ident
from recordings.rig import Axis, Rig

BENCH = Rig(name="bench", mechanism="axes", axes=(Axis(),))


def measured(seed: int) -> ident.Recording:
    """One axis with a dent in its bearing at 0.35 rad; in place of these lines stand your own recordings."""
    rng, time, speed = np.random.default_rng(seed), np.arange(4000) / 200, np.array([1.6, 3.1, 4.7]) + 0.3 * seed
    angle, size = np.outer(time, speed) + rng.uniform(0, 6, 3), np.array([0.8, 0.4, 0.2])
    q, qd, qdd = np.sin(angle) @ size, np.cos(angle) @ (size * speed), -np.sin(angle) @ (size * speed**2)
    rubs = (0.4 + 0.5 * np.exp(-(((q - 0.35) / 0.15) ** 2))) * np.sign(qd)
    effort = 0.05 * qdd + 0.2 * qd + rubs + rng.normal(0, 0.02, len(time))
    return ident.Recording.from_arrays(time, q, effort=effort, rig=BENCH)


train, other = measured(0), measured(1)
diagnosis = ident.diagnose(train, validate=other, effect_files="tight_spot.py")
print(diagnosis)
q_0 = diagnosis.model.parameters["tight_spot.q_0"]
print(f"the angle: {q_0.value:.3f} {q_0.unit}, 95 % from {q_0.ci95[0]:.3f} to {q_0.ci95[1]:.3f}")

q = np.linspace(-1, 1, 400)[:, None]
figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
for name, model in {"without": ident.fit(train, method="ls"), "with tight_spot": diagnosis.model}.items():
    axes.plot(q, model.torque(q, np.full_like(q, 0.5), 0 * q), label=name)
axes.plot(q, 0.1 + 0.4 + 0.5 * np.exp(-(((q - 0.35) / 0.15) ** 2)), "k--", label="true")
axes.set(xlabel="angle [rad]", ylabel="torque at 0.5 rad/s [N m]")
axes.legend()
figure.savefig("own_effect.png")
