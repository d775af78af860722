"""The report: one HTML file that shows a model against recordings, what is missing, and how to do it again."""
