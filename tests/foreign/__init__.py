"""A second plant, which shares nothing with the simulated rig or with `ident` but the geometry's kinematics.

It does not simulate: it prescribes a motion and works out the torque that the motors must give for it (inverse
dynamics of the exact robot with uniform rods), with each effect as the formula of the list of effects. The torque
becomes voltage, the motion encoder counts, both a CSV file, and that a recording by `daq import`. Effects are
described - names, parameters, ranges - as in `drivers.simulated`; their laws are written anew here.

`python -m tests.foreign FOLDER --effect stribeck --size 0.03 --seed 1` makes a pair of recordings.
"""
