"""From `.wms` text to a syntax tree with source spans, and the diagnostics that point into it."""
