"""Interactive figures for the report and the workbench, one file per topic.

Each function takes existing results and returns a Plotly figure; it computes only what drawing needs. The colours of
traces suit both themes: `figure.update_layout(template=theme.DARK)` is the only difference between light and dark.
"""
