"""Parser: `.wms` text to a syntax tree with source spans, and diagnostics that point into the text."""
