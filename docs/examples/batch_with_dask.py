"""A batch of recordings with Dask: ten nights of one axis, whose grease ages, fitted side by side."""

import dask
import matplotlib.pyplot as plt
import numpy as np

import ident
from recordings.rig import Axis, Rig

BENCH = Rig(name="bench", mechanism="axes", axes=(Axis(),))


def measured(night: int) -> ident.Recording:
    """One night; in place of these lines stand paths of files."""
    rng, time, speed = np.random.default_rng(night), np.arange(2000) / 200, np.array([1.6, 3.1, 4.7])
    angle, size = np.outer(time, speed) + rng.uniform(0, 6, 3), np.array([0.8, 0.4, 0.2])
    q, qd, qdd = np.sin(angle) @ size, np.cos(angle) @ (size * speed), -np.sin(angle) @ (size * speed**2)
    effort = 0.05 * qdd + (0.2 + 0.01 * night) * qd + 0.4 * np.sign(qd) + rng.normal(0, 0.05, len(time))
    return ident.Recording.from_arrays(time, q, effort=effort, rig=BENCH)


if __name__ == "__main__":  # the workers import this file
    fits = [dask.delayed(ident.fit)(measured(night), method="ls") for night in range(10)]
    models = dask.compute(*fits, scheduler="processes", num_workers=2)
    viscous = [model.parameters["c_v1"] for model in models]
    for night, found in enumerate(viscous):
        print(f"night {night}: {found.value:.3f} {found.unit}, 95 % from {found.ci95[0]:.3f} to {found.ci95[1]:.3f}")

    figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
    values, ends = np.array([found.value for found in viscous]), np.array([found.ci95 for found in viscous]).T
    axes.errorbar(range(10), values, abs(ends - values), fmt="o", capsize=4, label="found, 95 %")
    axes.plot(range(10), 0.2 + 0.01 * np.arange(10), "k--", label="true")
    axes.set(xlabel="night", ylabel=f"viscous friction [{viscous[0].unit}]")
    axes.legend()
    figure.savefig("batch_with_dask.png")
