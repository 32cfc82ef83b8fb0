"""How many examples of a law are tried: few for every change, many with `--hypothesis-profile long`."""

from __future__ import annotations

from typing import Any

from hypothesis import settings


def examples(few: int, many: int, **others: Any) -> settings:
    """Settings of a test whose examples take long: `many` in `make test-all`; the others are those of Hypothesis."""
    return settings(max_examples=many if settings.get_current_profile_name() == "long" else few, **others)
