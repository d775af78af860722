"""The fault campaign: what happens to a run when bus, drives, machine, host or operator misbehave (`make faults`)."""
