"""Confidence intervals of parameters, identifiability, and an assessment of the fit."""
