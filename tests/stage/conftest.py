"""Importing the schema first lets USD know our types in every test, whatever runs first."""

import wmspec.sim.usd.schema  # noqa: F401
