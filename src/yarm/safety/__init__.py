"""What stops a robot before it touches: clearances ahead, and the monitor's verdicts."""
