"""The version of the stage format, in a module that does not load USD."""

FORMAT_VERSION = 1
"""The `wms:formatVersion` of stages that this version reads and writes."""
