"""Interactive figures of what the other modules found, for the report and the workbench. One topic is one file.

Each function takes existing results and returns a Plotly figure; nothing is computed here but what drawing needs. The
colours of traces suit light and dark alike: `figure.update_layout(template=theme.DARK)` is all that changes.
"""
