"""Compare estimators as the paper does: PSO against RLS, DLS and SVD, on a motion that no fit has seen."""

import matplotlib.pyplot as plt
import numpy as np

import ident

METHODS = ("pso", "ls", "rls", "dls", "svd")

models = {name: ident.fit("fig5a.mcap", validate="fig5b.mcap", method=name, bare=True) for name in METHODS}
fitness = {name: model.file.validate_.fitted.nrmse for name, model in models.items()}
for name, values in fitness.items():
    print(f"{name:4}", *(f"{value:.4f}" for value in values))

figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
for number, (name, values) in enumerate(fitness.items()):
    axes.bar(np.arange(3) + 0.16 * number, values, 0.14, label=name)
axes.set(xticks=np.arange(3) + 0.32, xticklabels=["joint 1", "joint 2", "joint 3"])
axes.set(ylabel="fitness (41), held out", ylim=(0, 1.2))
axes.legend(ncols=5, loc="upper center")
figure.savefig("estimators.png")
