"""Reports on results of models and people: a page, figures, tables and JSON."""
