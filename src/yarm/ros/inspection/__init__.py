"""Nodes of the inspection: the recogniser of tags, and the inspector that drives a round."""
