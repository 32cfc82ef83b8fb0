"""Environments of processes whose wall clock jumps by days, forwards and backwards, each time that it is read."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

DAY = 86_400
#: For Python alone.
_PYTHON = f"""
import itertools, time
_reads, _true, _true_ns = itertools.count(), time.time, time.time_ns
def _shift():
    read = next(_reads)
    return {DAY} * (1 + read % 5) * (-1) ** read
time.time = lambda: _true() + _shift()
time.time_ns = lambda: _true_ns() + _shift() * 10**9
"""
#: For all of a process, such as SQLite, in place of functions of the C library.
_LIBRARY = f"""
#define _GNU_SOURCE
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static long shift(void) {{
    static long reads;
    long read = __sync_fetch_and_add(&reads, 1);
    return {DAY}L * (1 + read % 5) * (read % 2 ? -1 : 1);
}}

int clock_gettime(clockid_t which, struct timespec *now) {{
    int failed = syscall(SYS_clock_gettime, which, now);
    if (!failed && which == CLOCK_REALTIME) now->tv_sec += shift();
    return failed;
}}

int gettimeofday(struct timeval *now, void *zone) {{
    (void)zone;
    struct timespec exact;
    int failed = clock_gettime(CLOCK_REALTIME, &exact);
    now->tv_sec = exact.tv_sec;
    now->tv_usec = exact.tv_nsec / 1000;
    return failed;
}}

time_t time(time_t *kept) {{
    struct timespec exact;
    clock_gettime(CLOCK_REALTIME, &exact);
    if (kept) *kept = exact.tv_sec;
    return exact.tv_sec;
}}
"""


def jumping_in_python(folder: Path) -> dict[str, str]:
    """The environment of a process in which `time.time` jumps."""
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(_PYTHON)
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])}


def jumping_everywhere(folder: Path) -> dict[str, str] | None:
    """The environment of a process in which the wall clock of the C library jumps; None without a compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    folder.mkdir()
    source, library = folder / "clock.c", folder / "clock.so"
    source.write_text(_LIBRARY)
    subprocess.run([compiler, "-shared", "-fPIC", "-o", library, source], check=True)
    return {**os.environ, "LD_PRELOAD": str(library)}
