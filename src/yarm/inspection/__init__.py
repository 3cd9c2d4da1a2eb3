"""One robot visits known boxes, reads their tags and comes home in time."""
