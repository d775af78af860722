"""The report: one HTML file that compares models with recordings, with findings and the commands to reproduce it."""
