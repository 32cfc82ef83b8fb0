"""A conformance suite for engines that read UsdPhysics: stages whose motion mechanics knows, and how far they are off.

Nothing here knows of questions. A stage is standard USD without any schema of ours; an engine outside wmspec is scored
by the traces that it writes.
"""
