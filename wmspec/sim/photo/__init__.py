"""The photo look: Mitsuba traces paths of light through any scene, whichever engine executed it.

Begins with `renderer.py`. It is given the same scene as the engines' renderers, and the renderer of one of them for
what a picture says besides its colours: which body is where, and how far away.
"""
