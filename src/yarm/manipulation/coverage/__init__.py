"""Ways over a floor: every cell once, and from checkpoint to checkpoint."""
