"""The report of `dp detection`: how well the drivers of a vessel find ventilation."""
