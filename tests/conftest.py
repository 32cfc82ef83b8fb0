"""Settings of all tests."""

import os

from hypothesis import settings

# Time limits belong in benchmarks: a loaded machine must not fail a law. In CI the same examples are tried every time.
settings.register_profile("wmspec", deadline=None, derandomize=bool(os.environ.get("CI")))
settings.load_profile("wmspec")
