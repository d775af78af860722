"""Measurements that can be run: `python -m benchmarks.<name>`."""

import os

os.environ["DELTA_WORKBENCH_EFFECTS"] = ""  # what a user has adopted is no part of any benchmark
os.environ["DELTA_WORKBENCH_POSES"] = ""  # nor where its drives stood
