"""A model beside a robot that works: its residual, block by block, against what it left in healthy recordings.

`residual_follower` computes the residual of a recording that comes in pieces, `blocks` its means at places of the
motion, `baseline` what they are in healthy recordings, and `monitor` raises the alarm by the evidence of
`ident.sequential.ranges`. `watching` is the whole, line by line.
"""
