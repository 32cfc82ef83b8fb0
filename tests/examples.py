"""How much of a law is tried: few cases and examples in `make test`, all or many in `make test-all`."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import pytest
from hypothesis import settings


def examples(few: int, many: int, **others: Any) -> settings:
    """Settings of a test whose examples take long: `many` in `make test-all`; the others are those of Hypothesis."""
    return settings(max_examples=many if settings.get_current_profile_name() == "long" else few, **others)


def slow_except(quick: Collection[Any], cases: Iterable[Any]) -> list[Any]:
    """Parameters of a test; those that are not quick run in `make test-all` alone. A tuple is a case of several."""
    values = ((case, case if isinstance(case, tuple) else (case,)) for case in cases)
    return [case if case in quick else pytest.param(*each, marks=pytest.mark.slow) for case, each in values]
