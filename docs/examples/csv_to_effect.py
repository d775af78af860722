"""From a CSV to a named effect: two motions of a robot that has something that its model lacks."""

import subprocess

import matplotlib.pyplot as plt

import ident

# In place of these lines stand the tables that you have: time, position_1 ..., voltage_1 ... or effort_1 ...
for name in ("fig5a", "fig5b"):
    record = f"daq record --traj {name} --cycles 2 --rate 250 --hidden 9 --out robot_{name}.mcap"
    for command in (record, f"daq export robot_{name}.mcap --to csv"):
        subprocess.run(command.split(), check=True, capture_output=True)

diagnosis = ident.diagnose(ident.read("robot_fig5a.csv"), validate=ident.read("robot_fig5b.csv"))
print(diagnosis.document.sentence)
for finding in diagnosis.findings:
    print(finding.effect, "on joints", finding.joints)

steps, joints = diagnosis.document.steps, range(len(diagnosis.document.joints))
figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
for number, (step, label) in enumerate(zip(steps, diagnosis.document.labels, strict=True)):
    axes.bar([joint + 0.25 * number for joint in joints], step.held_out_rms, 0.22, label=label)
for joint, noise in enumerate(diagnosis.document.noise_rms):
    axes.plot([joint - 0.15, joint + 0.65], [noise, noise], "k--", label="" if joint else "noise floor")
axes.set(xticks=[joint + 0.25 for joint in joints], xticklabels=diagnosis.document.joints)
axes.set(ylabel="held-out error, RMS [N m]")
figure.legend(loc="outside right upper")
figure.savefig("csv_to_effect.png")
