"""`dp propeller`: study, tables, figures, files."""
