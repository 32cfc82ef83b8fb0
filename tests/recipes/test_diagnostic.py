"""The recipe "adding a diagnostic", carried out on a copy: a row, a page, a rule, and a case of the corpus."""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_adding_a_diagnostic(tmp_path: Path) -> None:
    for part in ("wmspec", "backends", "grammar", "specs", "tests/language", "tests/corpus"):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    for file in (ROOT / "pyproject.toml", *(ROOT / "tests").glob("*.py")):
        shutil.copy(file, tmp_path / file.relative_to(ROOT))

    codes = tmp_path / "wmspec/lang/parse/codes"
    _insert(codes / "__init__.py", "}", '    "WMS699": "object called moon",\n')
    (codes / "WMS699.md").write_text(PAGE.format(wrong=SPEC.format("moon"), right=SPEC.format("ball")))
    rules = tmp_path / "wmspec/compile/lint/task_rules.py"
    _insert(rules, "RULES = (", MOON)
    rules.write_text(rules.read_text().replace("RULES = (", "RULES = (object_called_moon, "))
    case = tmp_path / "tests/corpus/moon.wms"
    case.write_text(SPEC.format("moon"))

    tests = ("tests/language/test_corpus.py", "tests/language/test_explain.py")
    chosen = ("-k", "moon or WMS699 or every_code or without_a_code")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--basetemp=made", *tests, *chosen]
    environment = {"PYTHONPATH": str(tmp_path), "PATH": "/usr/bin:/bin", "UPDATE_CORPUS": "1"}
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert case.with_suffix(".expected").read_text() == "warning WMS699 3:10 `moon` is far | call it `ball`\n"


SPEC = """use room
task t : custom {{
  object {} {{ shape: sphere  size: 10 cm  on: floor }}
  observe front at [0 s]
}}
"""
PAGE = """# WMS699: object called moon

It is far.

## Wrong

```wms
{wrong}```

## Right

```wms
{right}```

## How to fix it

Call it `ball`.
"""
MOON = '''
@rule("WMS699")
def object_called_moon(task: Task) -> Iterator[Breach]:
    """An object that is too far away for its size."""
    for thing in task.spec.things:
        if thing.name == "moon":
            yield Breach("`moon` is far", thing.place, "call it `ball`")


'''


def _insert(path: Path, before: str, text: str) -> None:
    lines = path.read_text().splitlines(keepends=True)
    at = next(i for i, line in enumerate(lines) if line.startswith(before))
    path.write_text("".join([*lines[:at], text, *lines[at:]]))
