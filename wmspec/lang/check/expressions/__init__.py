"""Checks expressions: names, operators, calls, members, lists."""
