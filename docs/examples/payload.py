"""What a recording with a known payload gives: gains of the motors, and with them absolute masses."""

import subprocess
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import ident
from ident.identification.torque_calibration import calibrate

GAIN, MASS, PAYLOAD = (1.15, 1.1, 1.2), 2.033, 1.0  # true gains [N m/V^2] and platform [kg], which nobody knows; [kg]

for name, payload in (("empty", 0.0), ("loaded", PAYLOAD)):
    Path(f"{name}.toml").write_text(f"torque_gain = {list(GAIN)}\n[links]\npayload = {payload}\n")
    command = f"daq record --traj fig5a --cycles 1 --rate 250 --sim {name}.toml --out {name}.mcap"
    subprocess.run(command.split(), check=True, capture_output=True)

empty, loaded = ident.read("empty.mcap"), ident.read("loaded.mcap")
calibration = calibrate(empty, loaded, PAYLOAD)
told = replace(empty, rig=empty.rig.model_copy(update={"torque": calibration.torque}))
models = {"assumed gain": ident.fit(empty, method="wls"), "calibrated": ident.fit(told, method="wls")}
for name, model in models.items():
    print(f"{name}: m_p = {float(model.parameters['m_p']):.3f} kg; it is {MASS} kg")

figure, (left, right) = plt.subplots(1, 2, figsize=(7, 3), layout="constrained")
gain, joints = np.array(calibration.torque.gain), np.arange(1, 4)
left.errorbar(joints, gain, abs(calibration.intervals.T - gain), fmt="o", capsize=4, label="found, 95 %")
left.plot(joints, GAIN, "k_", markersize=20, label="true")
left.set(xlabel="joint", ylabel="gain [N m/V²]", xticks=joints)
left.legend()
right.bar(list(models), [float(model.parameters["m_p"]) for model in models.values()], 0.5)
right.axhline(MASS, color="black", linestyle="--", label="true")
right.set(ylabel="mass of the platform [kg]")
right.legend()
figure.savefig("payload.png")
