"""Show results: tables on the console, figures, the report."""
