"""Commissioning of drives: homing, and small motions of one joint."""
