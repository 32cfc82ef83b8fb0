"""Tests the installation and names remedies."""
