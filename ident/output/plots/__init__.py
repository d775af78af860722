"""Draw results as PNG files."""
