"""The arm coursework as a demo: kinematics, tours, the obstacle task, coverage, with pictures."""
