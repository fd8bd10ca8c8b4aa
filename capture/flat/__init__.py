"""The two-dimensional fish of KS: its scaffold, water, muscles, learning, plots and films."""
