"""Equal-error benchmarks of generation: `python -m benches.generate`, or `make bench-generate`."""
