"""Sections of the report. Each function makes one section from the contents."""
