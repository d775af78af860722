"""Diagnoses recordings of real machines and compares the claims with what is known about them.

Each data set is one file of `data_sets`: where it is from, how to get it, how to read it, and what is known and from
where. Nothing of it is part of the product.
"""
