"""Checking a task statement by statement: every mistake is reported, then the next statement is looked at."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import TypeVar

from wmspec.check import ir
from wmspec.check.evaluate import parts
from wmspec.check.expressions import ZERO, Expressions, Failed, Typed, constant
from wmspec.check.kinds import (
    A_TIME,
    ACTION,
    CAMERA,
    OBJECT,
    PICTURE,
    TEXT,
    TRUTH,
    Kind,
    List,
    Quantity,
    Word,
)
from wmspec.check.scope import Scope
from wmspec.check.units import NUMBER
from wmspec.check.vocabulary import PROPERTIES, SETTINGS, VERBS, Slot
from wmspec.errors import suggestion
from wmspec.parse import syntax as s
from wmspec.parse.diagnostics import Note, Report
from wmspec.parse.load import Program, load
from wmspec.parse.parser import parse_expression
from wmspec.parse.source import Source, Span

S = TypeVar("S", bound=s.Statement)
T = TypeVar("T")
_HOLE = re.compile(r"\{([^{}]*)\}")


def check(path: Path, report: Report) -> tuple[ir.TaskSpec, ...]:
    """The tasks of a spec file. Mistakes go to the report; tasks with mistakes are left out."""
    return check_program(load(path, report), report)


def check_program(program: Program, report: Report) -> tuple[ir.TaskSpec, ...]:
    """The tasks of a parsed spec. A library (a file without tasks) is checked and yields none."""
    library = [item for file in program.libraries for item in file.items if not isinstance(item, s.Task)]
    shared = [item for item in program.file.items if not isinstance(item, s.Task)]
    tasks = [item for item in program.file.items if isinstance(item, s.Task)]
    if not tasks:
        _Task(None, [*library, *shared], report).library()
        return ()
    specs = [_Task(task, [*library, *shared, *task.body], report).task() for task in tasks]
    return tuple(spec for spec in specs if spec is not None)


class _Task:
    def __init__(self, task: s.Task | None, statements: list[s.Statement], report: Report) -> None:
        self.declaration = task
        self.statements = statements
        self.report = report
        self.scope = Scope(statements, report)
        self.check = Expressions(self.scope, report)
        self.lets: list[ir.Let] = []

    # ------------------------------------------------------------ the whole

    def library(self) -> None:
        self.each(s.Factor, self.factor)
        self.each(s.Let, self.let)
        self.each(s.Block, self.block)

    def task(self) -> ir.TaskSpec | None:
        assert self.declaration is not None
        path = [n.id for n in self.declaration.path]
        factors = self.each(s.Factor, self.factor)
        lets = self.each(s.Let, self.let)
        requires = self.each(s.Require, self.require)
        things = [*self.each(s.Block, self.block), *self.each(s.Action, self.action)]
        observations = self.each(s.Observe, self.observe)
        settings = self.settings()
        questions = self.each(s.Question, self.question)
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
            repeat=self.repeat(),
            things=tuple(things),
            horizon=self.horizon(observations),
            observations=tuple(observations),
            questions=tuple(questions),
        )
        self.idle_factors(spec)
        return None if self.report.failed else spec

    def each(self, sort: type[S], check: Callable[[S], T]) -> list[T]:
        """The results of checking every statement of a sort, without those that failed."""
        results = []
        for statement in self.statements:
            if isinstance(statement, sort):
                try:
                    results.append(check(statement))
                except Failed:
                    continue
        return results

    def _docstring(self) -> str:
        assert self.declaration is not None
        texts = [x.text for x in [*self.declaration.body, *self.statements] if isinstance(x, s.Docstring)]
        return texts[-1] if texts else ""

    def _headline(self) -> str:
        assert self.declaration is not None
        return self._docstring().partition("\n")[0].partition(":")[0] or self.declaration.name.id

    # ------------------------------------------------------------ the design

    def factor(self, factor: s.Factor) -> ir.Factor:
        name = factor.name.id
        typed = self.check.infer(factor.domain)
        kind = self.check.factor_kind(factor)
        interval = isinstance(factor.domain, s.Range) and factor.domain.step is None and factor.domain.count is None
        if interval and not factor.nuisance:
            self.check.fail("WMS401", f"`{name}` is a factor and so needs separate values", factor.domain.span,
                            "add `by STEP` or `in COUNT`; only a nuisance is drawn from a whole interval")  # fmt: skip
        values = self.values(typed.expr, factor)
        domain = (
            ir.Interval(low=float(values[0]), high=float(values[1])) if interval else ir.Choices(values=tuple(values))
        )
        if isinstance(domain, ir.Interval) and domain.high < domain.low:
            self.check.fail(
                "WMS401", "this interval is empty: it goes up from its start to its end", factor.domain.span
            )
        unit = kind.dimension.symbol if isinstance(kind, Quantity) and kind.dimension != ZERO else ""
        return ir.Factor(name=name, domain=domain, nuisance=factor.nuisance, unit=unit, place=place(factor.name.span))

    def values(self, domain: ir.Expr, factor: s.Factor) -> list[bool | float | str]:
        """The constants of a domain. Two equal ones are a mistake."""
        assert isinstance(domain, ir.Items)
        written = factor.domain.items if isinstance(factor.domain, s.Items) else ()
        spans = [w.span for w in written] or [factor.domain.span] * len(domain.items)
        values: list[bool | float | str] = []
        for item, span in zip(domain.items, spans, strict=True):
            value = item.value if isinstance(item, ir.Value) else constant(item)
            if value is None:
                self.check.fail("WMS401", "the values of a domain are constants", span, "write them out")
            if value in values and len(written) > 0:
                self.check.fail("WMS401", "this value is in the domain twice", span, "remove one")
            values.append(value)
        if not values:
            self.check.fail("WMS401", f"`{factor.name.id}` has no values", factor.domain.span)
        return values

    def let(self, let: s.Let) -> ir.Let:
        typed = self.check.once(("let", let.name.id), let.name.span, lambda: self.check.infer(let.value))
        return ir.Let(name=let.name.id, value=typed.expr, place=place(let.name.span))

    def require(self, require: s.Require) -> ir.Require:
        typed = self.check.value(require.condition, (TRUTH,), "`require`")
        return ir.Require(condition=typed.expr, text=require.condition.span.text, place=place(require.condition.span))

    def settings(self) -> dict[str, str]:
        found: dict[str, s.Setting] = {}
        for x in self.statements:
            if isinstance(x, s.Setting):
                if x.key in found:
                    notes = (Note("said here first", found[x.key].span),)
                    self.report.add("WMS202", f"`{x.key}` is said twice", x.span, "remove one", notes)
                found[x.key] = x
        self._settings = found
        return {k: x.value.value for k, x in found.items() if isinstance(x.value, s.Text)}

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
        return int(count)

    def horizon(self, observations: list[ir.Observation]) -> ir.Expr:
        typed = self.setting("horizon")
        if typed is not None:
            return typed.expr
        times = tuple(t for o in observations if isinstance(o.times, ir.Items) for t in o.times.items)
        return ir.Call(function="max", arguments=times)

    # ------------------------------------------------------------ the scene

    def block(self, block: s.Block) -> ir.Thing:
        table = PROPERTIES[block.kind]
        properties: dict[str, ir.Setting] = {}
        spans: dict[str, Span] = {}
        for p in block.properties:
            if p.name.id in spans:
                notes = (Note("set here first", spans[p.name.id]),)
                self.report.add("WMS202", f"`{p.name.id}` is set twice", p.name.span, "remove one", notes)
                continue
            spans[p.name.id] = p.name.span
            try:
                properties |= self.property(block, p, table)
            except Failed:
                continue
        for name, slot in table.items():
            if name not in properties and name not in spans:
                if slot.default is not None:
                    properties[name] = self.default(slot, block.name.span)
                elif not slot.optional:
                    self.report.add(
                        "WMS206", f"the {block.kind} `{block.name.id}` needs `{name}`: {slot.meaning}", block.name.span
                    )
        kind = block.kind
        assert kind in ("object", "camera", "light", "world")
        return ir.Thing(kind=kind, name=block.name.id, properties=properties, place=place(block.name.span))

    def property(self, block: s.Block, p: s.Property, table: dict[str, Slot]) -> dict[str, ir.Setting]:
        slot = self.check.slot(table, p.name, f"{_article(block.kind)}")
        if p.at is not None and p.name.id != "on":
            self.check.fail("WMS101", "`at` follows `on:` only", p.at.span, "write `at: (x, y, z)`")
        typed = self.check.setting(block, p, slot)
        self.bounds(typed.expr, slot, p.value.span, f"`{p.name.id}`")
        found = {p.name.id: ir.Setting(value=typed.expr, place=place(p.value.span))}
        if p.at is not None:
            at = self.check.value(p.at, table["at"].kinds, "`at`")
            found["at"] = ir.Setting(value=at.expr, place=place(p.at.span))
        return found

    def default(self, slot: Slot, span: Span) -> ir.Setting:
        return ir.Setting(value=default_value(slot), place=place(span))

    def bounds(self, expr: ir.Expr, slot: Slot, span: Span, what: str) -> None:
        value = constant(expr)
        if value is not None and (reason := out_of_bounds(value, slot)):
            self.check.fail("WMS304", f"{what} must be {reason}", span)

    # ------------------------------------------------------------ actions

    def action(self, action: s.Action) -> ir.Thing:
        verb = self.check.verb(action)
        assert isinstance(action.call, s.Call)
        table = VERBS[verb].arguments
        written = self.arguments(action.call, table, verb)
        properties: dict[str, ir.Setting] = {}
        self.check.subject = None
        for name, slot in table.items():
            if name not in written:
                if slot.default is None:
                    self.report.add("WMS205", f"`{verb}` needs `{name}`: {slot.meaning}", action.call.span)
                    continue
                properties[name] = self.default(slot, action.name.span)
                continue
            try:
                typed = self.check.value(written[name].value, slot.kinds, f"`{name}`")
                self.bounds(typed.expr, slot, written[name].value.span, f"`{name}`")
            except Failed:
                continue
            properties[name] = ir.Setting(value=typed.expr, place=place(written[name].value.span))
            if name == "object":
                self.check.subject = typed.expr
        self.check.subject = None
        properties |= self.timings(action, verb)
        return ir.Thing(
            kind="action", name=action.name.id, verb=verb, properties=properties, place=place(action.name.span)
        )

    def arguments(self, call: s.Call, table: dict[str, Slot], verb: str) -> dict[str, s.Argument]:
        found: dict[str, s.Argument] = {}
        names = list(table)
        for i, argument in enumerate(call.arguments):
            name = argument.name.id if argument.name else names[i] if i < len(names) else ""
            if name not in table:
                shown, span = (
                    (argument.name.id, argument.name.span) if argument.name else (argument.span.text, argument.span)
                )
                self.report.add("WMS205", f"`{verb}` has no argument `{shown}`", span, suggestion(shown, table))
            elif name in found:
                self.report.add("WMS205", f"`{name}` is given twice", argument.span, "remove one")
            else:
                found[name] = argument
        return found

    def timings(self, action: s.Action, verb: str) -> dict[str, ir.Setting]:
        start = ir.Setting(value=ir.Value(value=0.0), place=place(action.name.span))
        duration = None
        for timing in action.timings:
            where = place(timing.value.span)
            if timing.kind in ("after", "with"):
                start = ir.Setting(value=self.relative(timing), place=where)
            else:
                typed = self.check.value(timing.value, (A_TIME,), f"`{timing.kind}`")
                self.bounds(typed.expr, Slot((A_TIME,), "", least=0), timing.value.span, f"`{timing.kind}`")
                if timing.kind == "at":
                    start = ir.Setting(value=typed.expr, place=where)
                else:
                    duration = ir.Setting(value=typed.expr, place=where)
        if VERBS[verb].lasts and duration is None:
            self.check.fail(
                "WMS205", f"`{verb}` needs to know how long: `for TIME`", action.call.span, "add for instance `for 2 s`"
            )
        if not VERBS[verb].lasts and duration is not None:
            self.check.fail("WMS205", f"`{verb}` happens at once and cannot last", action.call.span, "remove `for`")
        return {"start": start} | ({"duration": duration} if duration else {})

    def relative(self, timing: s.Timing) -> ir.Expr:
        other = self.check.value(timing.value, (ACTION,), f"`{timing.kind}`")
        assert isinstance(other.expr, ir.Value)
        start = ir.Property(owner=other.expr, name="start")
        if timing.kind == "with":
            return start
        declared = self.scope.names[str(other.expr.value)]
        assert isinstance(declared, s.Action)
        if not VERBS[self.check.verb(declared)].lasts:
            return start
        return ir.Operation(operator="+", operands=(start, ir.Property(owner=other.expr, name="duration")))

    # ------------------------------------------------------------ observations

    def observe(self, observe: s.Observe) -> ir.Observation:
        camera = self.check.value(observe.camera, (CAMERA,), "`observe`")
        times = self.check.value(observe.times, (List(A_TIME), A_TIME), "`at`")
        expr = times.expr if isinstance(times.kind, List) else ir.Items(items=(times.expr,))
        assert isinstance(camera.expr, ir.Value)
        return ir.Observation(camera=str(camera.expr.value), times=expr, place=place(observe.span))

    # ------------------------------------------------------------ questions

    def question(self, question: s.Question) -> ir.Question:
        text = self.text(question.text)
        by_kind: dict[str, list[s.Clause]] = {}
        for clause in question.clauses:
            by_kind.setdefault(clause.kind, []).append(clause)
            if clause.kind in ("options", "answer", "distinct") and len(by_kind[clause.kind]) > 1:
                notes = (Note("said here first", by_kind[clause.kind][0].span),)
                self.report.add("WMS202", f"`{clause.kind}` is said twice", clause.span, "remove one", notes)
        if "answer" not in by_kind:
            self.check.fail("WMS501", "this question has no answer", question.text.span, "add `answer EXPRESSION`")
        answer, options, sort = self.answer(question, by_kind)
        ensures = [self.tried(lambda c=c: self.ensure(c)) for c in by_kind.get("ensure", [])]  # type: ignore[misc]
        margins = [self.tried(lambda c=c: self.margin(c)) for c in by_kind.get("margin", [])]  # type: ignore[misc]
        changes = [self.tried(lambda c=c: self.counterfactual(c)) for c in question.counterfactuals]  # type: ignore[misc]
        distinct = [self.tried(lambda c=c: self.distinct(c)) for c in by_kind.get("distinct", [])]  # type: ignore[misc]
        return ir.Question(
            text=text,
            sort=sort,
            options=options,
            answer=answer,
            margins=tuple(m for m in margins if m),
            ensures=tuple(e for e in ensures if e),
            distinct=distinct[0] if distinct else None,
            counterfactuals=tuple(c for c in changes if c),
            place=place(question.text.span),
        )

    def tried(self, check: Callable[[], T]) -> T | None:
        try:
            return check()
        except Failed:
            return None

    def measuring(self, e: s.Expr, wanted: tuple[Kind, ...], what: str) -> Typed:
        """Check an expression in which measured functions may stand."""
        self.check.measured = True
        try:
            return self.check.value(e, wanted, what) if wanted else self.check.infer(e)
        finally:
            self.check.measured = False

    def answer(self, question: s.Question, clauses: dict[str, list[s.Clause]]) -> tuple[ir.Expr, ir.Expr | None, str]:
        clause = clauses["answer"][0]
        answer = self.measuring(clause.value, (), "`answer`")
        if answer.kind == PICTURE:
            if "options" in clauses:
                self.check.fail(
                    "WMS502",
                    "the options of a picture question are its counterfactuals",
                    clauses["options"][0].span,
                    "remove `options`",
                )
            if not question.counterfactuals:
                self.check.fail("WMS502", "a picture question needs counterfactuals to choose from", clause.span,
                                "add `counterfactual NAME { ... }`")  # fmt: skip
            return answer.expr, None, "picture"
        if "options" not in clauses:
            self.check.fail(
                "WMS502",
                f"the answer is {_article(str(answer.kind))}, but there are no options",
                clause.span,
                "add `options [...]`",
            )
        if question.counterfactuals:
            span = question.counterfactuals[0].span
            what = "counterfactuals are the options of picture questions"
            self.check.fail("WMS502", what, span, "answer with `frame(CAMERA, TIME)`")
        options = self.check.value(clauses["options"][0].value, (List(answer.kind),), "`options`, like the answer,")
        if not isinstance(options.expr, ir.Items) or len(options.expr.items) < 2:
            self.check.fail("WMS502", "a question has two or more options", clauses["options"][0].value.span)
        return answer.expr, options.expr, str(answer.kind)

    def ensure(self, clause: s.Clause) -> ir.Require:
        typed = self.measuring(clause.value, (TRUTH,), "`ensure`")
        return ir.Require(condition=typed.expr, text=clause.value.span.text, place=place(clause.value.span))

    def margin(self, clause: s.Clause) -> ir.Margin:
        assert clause.bound is not None
        value = self.measuring(clause.value, (), "`margin`")
        if not isinstance(value.kind, Quantity):
            self.check.fail(
                "WMS302", f"`margin` wants a quantity, but this is {_article(str(value.kind))}", clause.value.span
            )
        bound = self.check.value(clause.bound, (value.kind,), "`apart by`")
        ratio = value.kind.dimension == NUMBER
        if ratio and (factor := constant(bound.expr)) is not None and factor < 1:
            self.check.fail("WMS304", "a ratio is apart by a factor of 1 or more", clause.bound.span)
        return ir.Margin(value=value.expr, bound=bound.expr, ratio=ratio, place=place(clause.span))

    def distinct(self, clause: s.Clause) -> ir.Expr:
        slot = PROPERTIES["object"]["radius"]
        typed = self.check.value(clause.value, slot.kinds, "`distinct by`")
        self.bounds(typed.expr, slot, clause.value.span, "`distinct by`")
        return typed.expr

    def counterfactual(self, counterfactual: s.Counterfactual) -> ir.Counterfactual:
        name = counterfactual.name.id
        if len(counterfactual.changes) != 1:
            many = len(counterfactual.changes)
            what = f"a counterfactual changes exactly one thing, but `{name}` changes {many}"
            remedy = "make one counterfactual of each change" if many else "say what would be different"
            self.check.fail("WMS503", what, counterfactual.name.span, remedy)
        change = counterfactual.changes[0]
        where = place(change.span)
        if change.kind == "order":
            self.check.fail(
                "WMS405", "a change of order is not supported yet", change.span, "change the actions' `start`"
            )
        if change.kind == "without":
            target = self.check.value(change.target, (ACTION,), "`without`").expr
            assert isinstance(target, ir.Value)
            return ir.Counterfactual(
                name=name, change="without", owner=str(target.value), property="", value=None, sort="", place=where
            )
        owner, prop, kinds, slot = self.target(change)
        assert change.value is not None
        typed = self.check.value(change.value, kinds, f"`{prop}`")
        self.bounds(typed.expr, slot, change.value.span, f"`{prop}`")
        if typed.expr == ir.Property(owner=ir.Value(value=owner), name=prop):
            self.check.fail("WMS503", "this is what it was before", change.value.span, "change the value")
        assert change.kind in ("action", "state")
        return ir.Counterfactual(
            name=name,
            change=change.kind,
            owner=owner,
            property=prop,
            value=typed.expr,
            sort=str(typed.kind),
            place=where,
        )

    def target(self, change: s.Change) -> tuple[str, str, tuple[Kind, ...], Slot]:
        target = change.target
        example = "push.speed" if change.kind == "action" else "ball.mass"
        if not isinstance(target, s.Member) or not isinstance(target.value, s.Name):
            self.check.fail(
                "WMS503", f"`{change.kind}` changes one named value", target.span, f"write something like `{example}`"
            )
        owner = self.check.infer(target.value)
        is_action = owner.kind == ACTION
        if (
            not isinstance(owner.expr, ir.Value)
            or is_action != (change.kind == "action")
            or owner.kind not in (ACTION, OBJECT, CAMERA)
        ):
            wanted = "an action" if change.kind == "action" else "an object or camera"
            self.check.fail(
                "WMS503",
                f"`{change.kind}` changes {wanted}, but this is {_article(str(owner.kind))}",
                target.value.span,
            )
        name, prop = str(owner.expr.value), target.name.id
        if is_action:
            kinds: tuple[Kind, ...] = (self.check.argument_kind(name, target.name),)
            declared = self.scope.names[name]
            assert isinstance(declared, s.Action)
            slot = VERBS[self.check.verb(declared)].arguments.get(prop, Slot((A_TIME,), "", least=0))
        else:
            slot = self.check.slot(PROPERTIES["object" if owner.kind == OBJECT else "camera"], target.name, f"`{name}`")
            kinds = slot.kinds
        return name, prop, kinds, slot

    def text(self, text: s.Text) -> tuple[str | ir.Said, ...]:
        """Split a text at its `{expression}`s and check them."""
        found: list[str | ir.Said] = []
        raw = text.span.text
        end = 1
        for hole in _HOLE.finditer(raw):
            found.append(_unescape(raw[end : hole.start()]))
            end = hole.end()
            span = Span(text.span.source, text.span.start + hole.start(1), text.span.start + hole.end(1))
            expr = parse_expression(span, self.report)
            if expr is None:
                raise Failed
            typed = self.check.infer(expr)
            sort = _sort(typed.kind)
            if sort is None:
                self.check.fail("WMS302", f"{_article(str(typed.kind))} cannot be said in a text", span)
            found.append(ir.Said(value=typed.expr, sort=sort))
        found.append(_unescape(raw[end:-1]))
        return tuple(part for part in found if part != "")

    # ------------------------------------------------------------ the whole again

    def idle_factors(self, spec: ir.TaskSpec) -> None:
        """Warn about factors that neither the scene nor a question depends on."""
        lets = {let.name: let.value for let in spec.lets}
        used: set[str] = set()
        stack = list(_effects(spec))
        while stack:
            for part in parts(stack.pop()):
                if isinstance(part, ir.Ref) and part.name not in used:
                    used.add(part.name)
                    if part.name in lets:
                        stack.append(lets[part.name])
        for statement in self.statements:
            if isinstance(statement, s.Factor) and statement.name.id not in used:
                what = "nuisance" if statement.nuisance else "factor"
                message = f"nothing depends on the {what} `{statement.name.id}`"
                remedy = "use it in an object, action or question, or remove it"
                self.report.add("WMS403", message, statement.name.span, remedy, severity="warning")


def _effects(spec: ir.TaskSpec) -> Iterator[ir.Expr]:
    yield spec.horizon
    for thing in spec.things:
        yield from (setting.value for setting in thing.properties.values())
    yield from (o.times for o in spec.observations)
    for q in spec.questions:
        yield q.answer
        yield from (p.value for p in q.text if isinstance(p, ir.Said))
        yield from (c.value for c in q.counterfactuals if c.value is not None)
        yield from (q.options,) if q.options else ()


def place(span: Span) -> ir.Place:
    """A span as the IR keeps it."""
    return ir.Place(file=span.source.name, line=span.line, column=span.column, start=span.start, end=span.end)


@cache
def default_value(slot: Slot) -> ir.Expr:
    """The value that a property or argument has when it is left out."""
    assert slot.default is not None
    source = Source("<default>", slot.default)
    report = Report()
    expr = parse_expression(Span(source, 0, len(slot.default)), report)
    assert expr is not None, slot
    return Expressions(Scope((), report), report).value(expr, slot.kinds, "the default").expr


def out_of_bounds(value: float, slot: Slot) -> str:
    """What a value must be and is not; empty if it is within the bounds of its slot."""
    if slot.above is not None and value <= slot.above:
        return f"more than {slot.above:g}"
    if slot.least is not None and value < slot.least:
        return f"at least {slot.least:g}"
    if slot.most is not None and value > slot.most:
        return f"at most {slot.most:g}"
    return ""


def _unescape(text: str) -> str:
    return re.sub(r"\\(.)", lambda m: {"n": "\n", "t": "\t"}.get(m[1], m[1]), text)


def _sort(kind: Kind) -> str | None:
    if isinstance(kind, Word | Quantity) or kind in (OBJECT, TEXT):
        return str(kind)
    return None


def _article(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeio' else 'a'} {noun}"
