"""From arrays in memory to a named effect, a figure, and a model for a controller."""

from pathlib import Path

import numpy as np

import ident


def measure(seed: int) -> ident.Recording:
    """One axis on a bench: in place of these lines stand the arrays of your own machine."""
    rng, time = np.random.default_rng(seed), np.arange(4000) / 200
    size, speed = np.array([0.8, 0.4, 0.2]), np.array([1.6, 3.1, 4.7]) + seed
    angle = np.outer(time, speed) + rng.uniform(0, 6, 3)
    q, qd, qdd = np.sin(angle) @ size, np.cos(angle) @ (size * speed), -np.sin(angle) @ (size * speed**2)
    torque = 0.05 * qdd + 0.2 * qd + 0.4 * np.sign(qd) + 0.3 * qd * np.abs(qd) + rng.normal(0, 0.01, 4000)
    return ident.Recording.from_arrays(time, q, effort=torque, rig="bench.toml")


Path("bench.toml").write_text('name = "bench"\nmechanism = "axes"\nrate = 200\n[[axes]]\ntype = "revolute"\n')
train, other = measure(0), measure(1)

diagnosis = ident.diagnose(train, validate=other)
print(diagnosis.document.sentence, [finding.effect for finding in diagnosis.findings])
diagnosis.plot().write_html("steps.html")

model = diagnosis.model
print(model.to_frame()[["value", "unit", "ci95_low", "ci95_high"]])
model.save("bench.model.json")
print(model.export("c", "controller"))
