"""Diagnoses cases again without one idea, or with half or twice a constant, to learn which of them the verdicts need.

`variants` finds the constants and rules, `ideas` lists what else can be off. `watching` tells, in one run of a case,
which variants can matter to it. `subjects` are the cases. `results` is the file of what was tried, and its table.
"""
