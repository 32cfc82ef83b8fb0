"""Results of models and people, as one page, figures, tables and JSON."""
