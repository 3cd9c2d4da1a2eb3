"""The physics world: bodies, contacts, time."""
