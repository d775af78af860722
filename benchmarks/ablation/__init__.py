"""Diagnoses cases again with half or twice a constant, to learn which of them the verdicts need.

`variants` finds the constants. `watching` tells, in one run of a case,
which variants can matter to it. `subjects` are the cases. `results` is the file of what was tried, and its table.
"""
