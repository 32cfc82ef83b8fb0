"""Audits that take less time."""

from __future__ import annotations

import pytest

from tests.audit.made import inject_rarely


@pytest.fixture
def roughly(monkeypatch: pytest.MonkeyPatch) -> None:
    """For tests of other things than the power of probes."""
    inject_rarely(monkeypatch)
