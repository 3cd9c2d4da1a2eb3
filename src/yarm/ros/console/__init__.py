"""The console node: what the server of ``yarm.console`` shows and asks of a running system."""
