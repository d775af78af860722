"""The hidden-effect benchmark: hide effects in a plant, diagnose its recordings blind, compare with the truth.

`python -m benchmarks.hidden_effects` records what is not recorded yet, diagnoses what this version of `ident` has not
diagnosed yet, and prints the figures. It can be stopped at any time and continued.
"""
