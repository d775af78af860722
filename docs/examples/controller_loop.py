"""The model in a controller loop: the same position loop with and without the model's torque fed forward."""

import matplotlib.pyplot as plt
import numpy as np

import ident

DT, STEPS, STIFFNESS, DAMPING = 0.002, 750, 900.0, 60.0  # [s], -, [N m/rad], [N m s/rad]

robot = ident.fit("fig5b.mcap", method="ls")  # stands for the machine: another recording, another model
model = ident.fit("fig5a.mcap", method="ls")  # what the controller knows

t = DT * np.arange(STEPS)[:, None]
omega, phase = 2 * np.pi * np.array([1.0, 1.3, 0.7]), np.array([0.0, 2.1, 4.2])
q_d, qd_d = 0.3 + 0.15 * np.sin(omega * t + phase), 0.15 * omega * np.cos(omega * t + phase)
qdd_d = -0.15 * omega**2 * np.sin(omega * t + phase)
fed = {"position loop alone": np.zeros_like(q_d), "with the model's torque": model.torque(q_d, qd_d, qdd_d)}

figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
for name, forward in fed.items():
    q, qd, error = q_d[:1].copy(), qd_d[:1].copy(), np.zeros_like(q_d)
    for step in range(STEPS):
        error[step] = q_d[step] - q[0]
        torque = forward[step] + STIFFNESS * error[step] + DAMPING * (qd_d[step] - qd)
        qd += DT * robot.acceleration(q, qd, torque)
        q += DT * qd
    print(f"{name}: following error {1000 * error.std():.2f} mrad (RMS)")
    axes.plot(t, 1000 * error[:, 0], label=name)
axes.set(xlabel="time [s]", ylabel="following error of joint 1 [mrad]")
axes.legend()
figure.savefig("controller_loop.png")
