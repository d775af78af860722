"""An arm from a URDF: what its links weigh and its joints rub, from positions and torques."""

import matplotlib.pyplot as plt
import numpy as np
import pinocchio

import ident

VISCOUS, COULOMB = np.array([0.8, 0.5]), np.array([1.5, 0.7])  # true friction of the two joints


def measured(seed: int) -> ident.Recording:
    """A motion of the true arm, by Pinocchio; in place of these lines stand your own arrays."""
    rng, time = np.random.default_rng(seed), np.arange(3000) / 200
    omega, phase = rng.uniform(1, 8, (5, 2)), rng.uniform(0, 6, (5, 2))
    angle = omega * time[:, None, None] + phase
    q, qd = (0.3 * np.sin(angle)).sum(axis=1), (0.3 * omega * np.cos(angle)).sum(axis=1)
    qdd = (-0.3 * omega**2 * np.sin(angle)).sum(axis=1)
    arm = pinocchio.buildModelFromUrdf("arm.urdf")
    effort = np.array([pinocchio.rnea(arm, arm.createData(), *at) for at in zip(q, qd, qdd, strict=True)])
    effort += VISCOUS * qd + COULOMB * np.sign(qd) + rng.normal(0, 0.2, q.shape)
    return ident.Recording.from_arrays(time, q, effort=effort, rig="arm.toml")


other = measured(1)
model = ident.fit(measured(0), validate=other, method="wls")
print(model)
print(model.to_frame()[["value", "unit", "ci95_low", "ci95_high"]].round(3))

residuals = ident.compare(model, other)
figure, axes = plt.subplots(1, 2, figsize=(7, 3), layout="constrained", sharex=True)
for joint, axis in enumerate(axes):
    prepared = residuals.predictions[0].prepared
    axis.plot(prepared.time, prepared.torque[:, joint], label="measured")
    axis.plot(prepared.time, residuals.predictions[0].residual[:, joint], label="residual")
    axis.set(title=f"joint {joint + 1}", xlabel="time [s]", ylabel="torque [N m]", xlim=(2, 6))
axes[1].legend()
figure.savefig("arm_from_urdf.png")
