"""Fault campaign: behaviour of a run under faults of bus, drives, machine, host or operator (`make faults`)."""
