"""Task assignment and planning; NumPy and SciPy only."""
