"""Benchmarks, comparisons, paper tables, soak tests."""
