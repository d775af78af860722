"""Alternative linear models of mechanisms. One form is one file here.

An estimator whose module contains `FORM = "name"` identifies that form instead of the mechanism's own model. A form's
module holds `MECHANISM`, the name of its mechanism, and `create(rig) -> Mechanism`.
"""
