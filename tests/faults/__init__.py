"""Fault campaign: behaviour of a run under faults of bus, drives, machine, host or operator (`make faults`)."""

import os

os.environ["DELTA_WORKBENCH_POSES"] = ""  # where drives stood on this machine is no part of any fault
