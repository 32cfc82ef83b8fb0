"""Progress output where there is no terminal."""

import pytest

from wmspec.api import progress, progress_bar


def test_a_line_every_tenth(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar(40, "making") as advance:
        for _ in range(40):
            advance("slide", 1)
    lines = capsys.readouterr().err.splitlines()
    assert lines == [f"{n} of 40 instances (slide)" for n in range(4, 41, 4)]


def test_line_after_a_long_silence(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr(progress, "monotonic", lambda: now)
    with progress_bar(10_000, "making") as advance:
        for _ in range(100):  # one every ten seconds
            now += 10
            advance("slide", 1)
    lines = capsys.readouterr().err.splitlines()
    assert lines == [f"{n} of 10000 instances (slide)" for n in (31, 62, 93)]
