"""The figures of a report, drawn with matplotlib as SVG: the same bytes for the same report."""
