"""The hidden-effect benchmark hides effects in a plant, diagnoses the recordings blind and compares with the truth.

`python -m benchmarks.hidden_effects` records and diagnoses the cases that are missing for this version of `ident`,
and prints the scores. It can be stopped at any time; the same command continues.
"""
