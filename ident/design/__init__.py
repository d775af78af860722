"""Excitation: motions inside the limits from which the parameters of a mechanism can be told best."""
