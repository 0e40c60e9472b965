"""`dp design`: studies, tables, figures, files."""
