"""From arrays in memory to a named effect, a figure, and a model for a controller."""

from pathlib import Path

import numpy as np

import ident

rng = np.random.default_rng(0)


def measure(orders: tuple[float, ...]) -> ident.Recording:
    """One axis on a bench: in place of these lines stand the arrays of your own machine."""
    time = np.arange(4000) / 200
    waves = [(0.8 / k, 0.5 * np.pi * k, k) for k in orders]
    q = sum(a * np.sin(w * time + phase) for a, w, phase in waves)
    qd = sum(a * w * np.cos(w * time + phase) for a, w, phase in waves)
    qdd = sum(-a * w**2 * np.sin(w * time + phase) for a, w, phase in waves)
    torque = 0.05 * qdd + 0.2 * qd + 0.4 * np.sign(qd) + 0.3 * qd * np.abs(qd)
    return ident.Recording.from_arrays(time, q, effort=torque + rng.normal(0, 0.01, 4000), rig="bench.toml")


Path("bench.toml").write_text('name = "bench"\nmechanism = "axes"\nrate = 200\n[[axes]]\ntype = "revolute"\n')
train, other = measure((1.0, 2.0, 3.0)), measure((1.0, 1.5, 4.0))

diagnosis = ident.diagnose(train, validate=other)
print(diagnosis.document.sentence)
print([finding.effect for finding in diagnosis.findings])
diagnosis.plot().write_html("steps.html")

model = diagnosis.model
print(model.to_frame()[["value", "unit", "ci95_low", "ci95_high"]])
model.save("bench.model.json")
print(model.export("c", "controller", on=other))
