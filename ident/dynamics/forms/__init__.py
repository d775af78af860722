"""Other linear models of a mechanism than its own. One form is one file here.

An estimator whose module says `FORM = "name"` identifies that form instead of the mechanism's own model. A form's
module holds `MECHANISM`, the name of the mechanism that it is a form of, and `create(rig) -> Mechanism`.
"""
