"""Proposal of a rig file from what drives say of themselves: in EDS and DCF files, or on the bus."""
