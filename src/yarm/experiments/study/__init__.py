"""The published study: trials in a kinematic world, across processes."""
