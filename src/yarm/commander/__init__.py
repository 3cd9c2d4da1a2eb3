"""The state machine as data, and the mission loop: pure step(state, event, now)."""
