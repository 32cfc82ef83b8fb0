"""Joints and articulations: coordinates, drives, limits, momentum."""
