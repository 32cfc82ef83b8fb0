"""The photo look: Mitsuba path-traces any scene, independent of the engine that executed it.

Starts in `tracer.py`. It receives the scene and an engine's renderer, which supplies ids and depth.
"""
