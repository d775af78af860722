"""Identify a model, judge it, keep it in a file, and predict torque with it."""
