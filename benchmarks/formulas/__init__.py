"""The formula benchmark hides laws that no effect of the library contains and asks for a formula.

`python -m benchmarks.formulas --folder FOLDER` records and diagnoses the cases that are missing for this version of
`ident`, and prints one table. It can be stopped at any time; the same command continues.
"""
