"""The run_experiment node and its launcher."""
