"""Asset importers: URDF, MJCF and USD files with several links and joints, expanded in place of the object that names
them.
"""
