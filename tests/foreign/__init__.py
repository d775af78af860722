"""A second plant that shares only the kinematics of the geometry with the simulated rig and with `ident`.

It does not simulate. It prescribes a motion and computes the motor torque by inverse dynamics of the exact robot with
uniform rods; each effect is added by its formula in the list of effects. The torque is converted to voltage and the
motion to encoder counts. Both are written to a CSV file, which `daq import` converts to a recording. Names,
parameters and ranges of the effects are those of `drivers.simulated`; their laws are implemented independently.

`python -m tests.foreign FOLDER --effect stribeck --size 0.03 --seed 1` creates a pair of recordings.
"""
