"""wmspec: controlled visual questions about a physical world, from one small language."""

__version__ = "0.1.0"
