"""The report's explorer, rebuilt: ``report`` as its text describes it, ``report_printed`` as its program runs."""
