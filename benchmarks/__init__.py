"""Measurements that can be run: `python -m benchmarks.<name>`."""
