"""One experiment: its record, verdict, tables and plots."""
