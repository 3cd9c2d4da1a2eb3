"""The hc10_state_machine node."""
