"""The console: what a person sees of a running system in a browser, and what can be asked of it there."""
