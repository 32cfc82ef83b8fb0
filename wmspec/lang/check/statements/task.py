"""Checks a task statement by statement; errors are reported and the next statement is checked."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from wmspec.core.diagnostics import Diagnostic, Note, Report, suggestion
from wmspec.core.limits import EPISODE_SECONDS
from wmspec.core.places import Source, Span
from wmspec.lang.check.expressions.expressions import Expressions
from wmspec.lang.check.expressions.scope import Scope
from wmspec.lang.check.expressions.typed import Failed, Typed, constant, without_failed
from wmspec.lang.check.ir import ir
from wmspec.lang.check.library.expand import Assets
from wmspec.lang.check.library.modules import Item, Modules
from wmspec.lang.check.library.substitute import Substitute
from wmspec.lang.check.library.templates import Templates
from wmspec.lang.check.statements.balance import balance
from wmspec.lang.check.statements.dimensions import warn_near_known
from wmspec.lang.check.statements.factors import Factors
from wmspec.lang.check.statements.films import check_film
from wmspec.lang.check.statements.holdouts import check_holdouts, holdouts
from wmspec.lang.check.statements.objects import Entities
from wmspec.lang.check.statements.observations import Observations
from wmspec.lang.check.statements.orbits import Orbits
from wmspec.lang.check.statements.placement_cycles import report_placement_cycles
from wmspec.lang.check.statements.questions import Questions
from wmspec.lang.check.statements.sets import Sets
from wmspec.lang.check.tables.vocabulary import SETTINGS, TOLERANCES
from wmspec.lang.parse import syntax as s
from wmspec.lang.parse.load import Program, load

_WORD = re.compile(r"[A-Za-z_]\w*")

S = TypeVar("S", bound=s.Statement)
T = TypeVar("T")


def check(path: Path, report: Report) -> tuple[ir.TaskSpec, ...]:
    """Return the tasks of a spec file. Errors are reported; after an error there are no tasks."""
    own = Report()
    tasks = check_program(load(path, own), own)
    report.merge(own)
    return tasks


def check_program(program: Program, report: Report) -> tuple[ir.TaskSpec, ...]:
    """Return the tasks of a parsed spec. A library (a file without tasks) is checked and yields none.

    On a line with a syntax error only that error is reported: later ones depend on the repair.
    """
    guessed = {_line(d) for d in report.diagnostics}
    own = Report()
    own.include(report.diagnostics)
    specs = _specs(program, own)
    report.names |= own.names
    report.include(d for d in own.diagnostics if not guessed or (_line(d) not in guessed and _of(d, program.source)))
    return specs


def _of(d: Diagnostic, source: Source) -> bool:
    """Whether a diagnostic belongs to this text, and not to a library."""
    return not isinstance(d.place, Span) or d.place.source is source


def _line(d: Diagnostic) -> object:
    return (d.place.source.name, d.place.line) if isinstance(d.place, Span) else d


def _specs(program: Program, report: Report) -> tuple[ir.TaskSpec, ...]:
    tasks = [item for item in program.file.items if isinstance(item, s.Task)]
    if not tasks:
        _Task(None, Modules(program, report), (program.file.items,), report, set()).library()
        return ()
    # Instances of two tasks of one name would be confused.
    report.add_repeated(((t.name.id, t.name.span) for t in tasks if t.name.id), "there are two tasks `{}`")
    specs = [spec for task in tasks for spec in _checked(task, program, report)]
    if not report.failed:
        warn_unused(program.file, report)
    return tuple(spec for spec in specs if spec is not None)


def _variants(task: s.Task, report: Report) -> list[s.Variant | None]:
    """Return the variants of a task; [None] for a task without variants."""
    named: dict[str, s.Variant] = {}
    for variant in (item for item in task.body if isinstance(item, s.Variant)):
        if (first := named.setdefault(variant.name.id, variant)) is not variant:
            notes = (Note("declared here first", first.name.span),)
            what = f"there are two variants `{variant.name.id}`"
            report.add("WMS202", what, variant.name.span, "give one of them another name", notes)
    return [*named.values()] or [None]


def _checked(task: s.Task, program: Program, report: Report) -> Iterator[ir.TaskSpec | None]:
    """Yield the tasks of the variants, each with the common statements of task and file."""
    unknown: set[str] = set()
    for variant in _variants(task, report):
        named = task
        if variant is not None:
            named = replace(task, name=replace(task.name, id=f"{task.name.id}_{variant.name.id}"))
        yield _Task(named, Modules(program, report), _items(program, task, variant), report, unknown).task()


def _items(program: Program, task: s.Task | None, variant: s.Variant | None) -> list[Iterable[Item]]:
    return [program.file.items, task.body if task else (), variant.body if variant else ()]


def scope_of(program: Program, task: s.Task | None, variant: s.Variant | None) -> Expressions:
    """Return the checker state of a variant, a task without variants, or a library; errors are ignored."""
    report = Report()
    return _Task(task, Modules(program, report), _items(program, task, variant), report, set()).check


def words_in(program: Program) -> frozenset[tuple[str, int]] | None:
    """Return where declared names of a program are words of the language, by file and offset; None if it has errors."""
    report, words = Report(), set[tuple[str, int]]()
    for task in (item for item in program.file.items if isinstance(item, s.Task)):
        for variant in _variants(task, report):
            made = _Task(task, Modules(program, report), _items(program, task, variant), report, set())
            made.task()
            words |= made.check.words
    return None if report.failed else frozenset(words)


#: Settings that a library may have too.
_CREDITS = ("license", "source")


class _Task:
    def __init__(
        self,
        task: s.Task | None,
        modules: Modules,
        items: Iterable[Iterable[Item]],
        report: Report,
        unknown: set[str],
    ) -> None:
        self.declaration = task
        self.report = report
        statements = modules.statements(*items)
        substitute = Substitute()
        templates = Templates(statements, substitute, report)
        self.statements = merged_worlds([templates.expanded(statement) for statement in statements], task)
        self.scope = Scope(self.statements, report, alone=not modules.any)
        self.scope.whole = self.scope.whole and modules.whole
        self.check = Expressions(self.scope, report, unknown)
        guessed = {_line(d) for d in report.diagnostics}
        declared = (x.name for x in self.statements if isinstance(x, s.Let | s.Factor) and guessed)
        self.check.tainted = {n.id for n in declared if (n.span.source.name, n.span.line) in guessed}
        self.factors = Factors(self.check)
        self.things = Entities(self.check)
        self.questions = Questions(self.check, modules, self.things, self.factors)
        self.observations = Observations(self.check)
        self._replace(Sets(self.check, self.factors, substitute).members, s.Block, s.Action, s.Factor)
        self._replace(Assets(self.check, substitute).expanded, s.Block)
        self.unused = list(templates.unused())
        report.names |= modules.written() | self.scope.written(modules.written())

    def _replace(self, made: Callable[[Any], Iterable[s.Statement]], *sorts: type[s.Statement]) -> None:
        """Replace statements of some types by their expansion, and by nothing where that fails."""
        statements: list[s.Statement] = []
        for statement in self.statements:
            with suppress(Failed):
                statements += made(statement) if isinstance(statement, sorts) else (statement,)
        self.statements = statements

    def library(self) -> None:
        self.each(s.Factor, self.factors.factor)
        self.each(s.Let, self.factors.let)
        self.holdouts()
        self.blocks()
        self.each(s.Action, self.things.action)
        self.each(s.Observe, self.observations.observe)
        self.each(s.Film, self.observations.film)
        self.tolerances()

    def tolerances(self) -> dict[str, float]:
        return tolerances(self.check, (x for x in self.statements if isinstance(x, s.Tolerance)))

    def holdouts(self) -> tuple[ir.Holdout, ...]:
        return holdouts(self.factors, (x for x in self.statements if isinstance(x, s.Holdout)))

    def blocks(self) -> list[ir.Entity]:
        """Return all entities. Unused templates are checked as well."""
        without_failed(self.things.block, self.unused)
        things = [thing for group in self.each(s.Block, self.things.block) for thing in group]
        report_placement_cycles(self.check, things)
        return things

    def task(self) -> ir.TaskSpec | None:
        assert self.declaration is not None
        path = [n.id for n in self.declaration.path]
        warn_near_known(self.declaration.path, self.report)
        factors = self.each(s.Factor, self.factors.factor)
        lets = self.each(s.Let, self.factors.let)
        requires = self.each(s.Require, self.factors.require)
        held_out = self.holdouts()
        things = [*self.blocks(), *self.each(s.Action, self.things.action)]
        observations = self.each(s.Observe, self.observations.observe)
        film = self.film()
        settings = self.settings()
        repeat, plan, limits = self.repeat(), self.factors.plan(), self.tolerances()
        horizon = self.horizon(observations)
        self.questions.orbits = Orbits(self.check, plan, factors, lets, requires, things)
        questions = self._questions()
        if not observations and not self.report.failed:
            self.report.add(
                "WMS504", "nothing is observed", self.declaration.name.span, "add `observe CAMERA at TIMES`"
            )
        if self.report.failed:
            return None
        spec = ir.TaskSpec(
            name=self.declaration.name.id,
            dimension=".".join(path) or "custom",
            title=str(settings.get("title") or self._headline()),
            description=self._docstring(),
            license=str(settings.get("license", "")),
            source=str(settings.get("source", "")),
            factors=tuple(factors),
            lets=tuple(lets),
            requires=tuple(requires),
            repeat=repeat,
            plan=plan,
            tolerances=limits,
            things=(*things, *self.questions.counterfactuals.added),
            horizon=horizon,
            observations=tuple(observations),
            questions=tuple(questions),
            film=film,
            holdouts=held_out,
        )
        balance(self.check, spec)
        check_holdouts(self.check, spec, self.statements)
        check_film(self.check, spec, self.statements)
        return None if self.report.failed else spec

    def film(self) -> ir.Film | None:
        """Return the film; a task has at most one."""
        written = (("film", x.span) for x in self.statements if isinstance(x, s.Film))
        self.report.add_set_twice(written, "a task has one film")
        return next(iter(self.each(s.Film, self.observations.film)), None)

    def _questions(self) -> list[ir.Question]:
        """Return the questions, those of the task's own text first, then those of its libraries."""
        assert self.declaration is not None
        text = self.declaration.span.source
        questions = self.each(s.Question, lambda q: (q.span.source is not text, self.questions.question(q)))
        return [question for _, question in sorted(questions, key=lambda pair: pair[0])]

    def each(self, sort: type[S], check: Callable[[S], T]) -> list[T]:
        """Return the results of checking every statement of a type, without failed ones."""
        return without_failed(check, (x for x in self.statements if isinstance(x, sort)))

    def _docstring(self) -> str:
        assert self.declaration is not None
        source = self.declaration.span.source  # a library's docstring describes the library
        texts = [x.text for x in self.statements if isinstance(x, s.Docstring) and x.span.source is source]
        return texts[-1] if texts else ""

    def _headline(self) -> str:
        assert self.declaration is not None
        return self._docstring().partition("\n")[0].partition(":")[0] or self.declaration.name.id

    # ------------------------------------------------------------ the task itself

    def settings(self) -> dict[str, str]:
        """Return the settings; licences and sources of libraries are joined to those of the task."""
        settings: dict[str, s.Setting] = {}
        joined: dict[str, dict[str, None]] = {key: {} for key in _CREDITS}
        for x in self.statements:
            if isinstance(x, s.Setting):
                if x.key in _CREDITS and isinstance(x.value, s.Text):
                    joined[x.key][x.value.value] = None
                earlier = settings.get(x.key)
                if earlier and (x.key not in _CREDITS or earlier.span.source is x.span.source):
                    notes = (Note("first set here", settings[x.key].span),)
                    self.report.add("WMS202", f"`{x.key}` is set twice", x.span, "remove one", notes)
                settings[x.key] = x
        self._settings = settings
        own = {k: x.value.value for k, x in settings.items() if isinstance(x.value, s.Text)}
        return own | {key: ir.CREDIT_SEPARATOR.join(texts) for key, texts in joined.items()}

    def setting(self, key: str) -> Typed | None:
        if key not in self._settings:
            return None
        try:
            return self.check.value(self._settings[key].value, (SETTINGS[key],), f"`{key}`")
        except Failed:
            return None

    def repeat(self) -> int:
        typed = self.setting("repeat")
        count = 1.0 if typed is None else constant(typed.expr)
        if count is None or count != int(count) or not 1 <= count <= 1_000_000:
            self.report.add(
                "WMS304", "`repeat` is a whole constant from 1 to 1000000", self._settings["repeat"].value.span
            )
            return 1
        if typed is not None and any(d.kind.id == "groups" for d in self.check.scope.designs):
            remedy = "remove it, and ask for more groups: `design groups of ...`"
            self.report.add("WMS408", "groups are not repeated", self._settings["repeat"].value.span, remedy)
        return int(count)

    def horizon(self, observations: list[ir.Observation]) -> ir.Expr:
        typed = self.setting("horizon")
        if typed is not None:
            if (constant(typed.expr) or 0.0) > EPISODE_SECONDS.most:
                span = self._settings["horizon"].value.span
                self.report.add("WMS304", f"`horizon` must be at most {EPISODE_SECONDS.most} s", span)
            return typed.expr
        return ir.time_of_last_picture(observations)


def merged_worlds(statements: Sequence[s.Statement], task: s.Task | None) -> list[s.Statement]:
    """Return the statements with the world of a library merged into the task's own, such as `world { gravity: 0 }`.

    Worlds of several libraries, and several of the task, are left as they are: these are mistakes.
    """
    worlds = [each for each in statements if isinstance(each, s.Block) and each.kind == "world"]
    own = [world for world in worlds if task is not None and world.span.source is task.span.source]
    others = [world for world in worlds if world not in own]
    if len(own) != 1 or len(others) != 1:
        return list(statements)
    written = {each.name.id for each in own[0].properties}
    inherited = (each for each in others[0].properties if each.name.id not in written)
    merged = replace(own[0], properties=(*own[0].properties, *inherited))
    return [merged if each is own[0] else each for each in statements if each is not others[0]]


def warn_unused(file: s.File, report: Report) -> None:
    """Warn about unused declarations of a file. A name that occurs in a text counts as used."""
    if not any(isinstance(item, s.Task) for item in file.items) or not file.whole:
        return
    used = Counter(name.id for name in s.nodes(file.items, s.Name))
    used.update(word for text in s.nodes(file.items, s.Text) for word in _WORD.findall(text.value))
    for item in s.statements(file.items):
        if not (isinstance(item, s.Let | s.Template) or (isinstance(item, s.Block) and item.kind == "camera")):
            continue
        what = "template" if isinstance(item, s.Template) else "camera" if isinstance(item, s.Block) else "value"
        if used[item.name.id] == 1:
            message = f"the {what} `{item.name.id}` is never used"
            report.add("WMS410", message, item.name.span, "use it, or remove it", severity="warning")


def tolerances(check: Expressions, written: Iterable[s.Tolerance]) -> dict[str, float]:
    """Return the tolerances (SI) by name; wrong ones are reported and left out."""
    every = list(written)
    check.report.add_set_twice(((x.name.id, x.name.span) for x in every), "the tolerance `{}` is set twice")
    return dict(without_failed(partial(_tolerance, check), every))


def _tolerance(check: Expressions, tolerance: s.Tolerance) -> tuple[str, float]:
    """Return the name and the value."""
    name = tolerance.name
    if name.id not in TOLERANCES:
        message = f"there is no tolerance `{name.id}`"
        check.fail("WMS203", message, name.span, suggestion(name.id, TOLERANCES))
    slot = TOLERANCES[name.id]
    typed = check.value(tolerance.value, slot.types, f"`{name.id}`")
    check.bounds(typed.expr, slot, tolerance.value.span, f"`{name.id}`")
    value = constant(typed.expr)
    if value is None:
        check.fail("WMS304", "a tolerance is a constant", tolerance.value.span, "write a quantity")
    return name.id, value
