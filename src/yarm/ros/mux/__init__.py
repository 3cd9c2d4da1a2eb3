"""The node that lets one of several sources of velocity commands through."""
