"""The version of the stage's format; apart from the schemas, so that knowing it does not load USD."""

FORMAT_VERSION = 1
"""The `wms:formatVersion` of the stages that this version reads and writes."""
