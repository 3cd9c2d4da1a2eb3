"""Run, record, score and plot experiments."""
