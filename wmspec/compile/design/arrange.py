"""Builds the control groups of a design: columns of factor values, and their arrangement."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain, combinations, islice

from wmspec.compile.design.blocks import Blocks, Groups, MemberOrder, RepeatedPlan, TooManyTied
from wmspec.compile.design.columns import Column, FreeFactor, Strata
from wmspec.compile.design.constrain import Constraint
from wmspec.compile.design.constraint_chain import MAX_COUNTED, Chain, TooManyCombinations
from wmspec.compile.design.levels import Level, format_levels
from wmspec.compile.design.plans import Arrangement, Factorial, Latin, Listed, Ranks, Sample
from wmspec.core.diagnostics import Note, SpecError
from wmspec.lang.check.ir.ir import Choices, TaskSpec

_EVEN = "remove the conditions on crossed factors, or remove `balance`"
#: Maximum number of subsets of conditions tried when searching for a minimal contradictory one.
MAX_SUBSETS = 500


def blocks(spec: TaskSpec, conditions: Sequence[Constraint], seed: int) -> Blocks:
    """Return the control groups of a task's design. Raises SpecError if the design is empty or infeasible."""
    columns: tuple[Column, ...] = (*_chains(spec, conditions), *_strata(spec, seed))
    key = (seed, spec.name, spec.plan.kind)
    if spec.plan.kind != "groups":
        order = MemberOrder(*key, "order")
        return RepeatedPlan(columns, _arrangement(spec, conditions, columns, key), spec.repeat, order)
    try:
        groups = Groups(columns, spec.plan.cross, spec.plan.turn, spec.plan.count or 1, key)
    except TooManyTied as tied:
        place = spec.plan.place or spec.factors[0].place
        names = ", ".join(tied.names[:6])
        what = f"conditions tie the crossed factors to too many others ({names}): groups cannot be enumerated"
        raise SpecError(what, place, "cross other factors, or tie fewer to one another", code="WMS404") from None
    if spec.plan.balance and not groups.even:
        what = "conditions make some groups larger than others, so that answers cannot be balanced among them"
        raise SpecError(what, spec.plan.place or spec.factors[0].place, _EVEN, code="WMS408")
    return groups


def _arrangement(
    spec: TaskSpec, conditions: Sequence[Constraint], columns: tuple[Column, ...], key: tuple[object, ...]
) -> Arrangement:
    """Return the arrangement of the columns that the plan of a spec describes."""
    count = spec.plan.count or 1
    match spec.plan.kind:
        case "sample":
            return Sample(columns, count, key)
        case "latin":
            return Latin(columns, count, key)
        case "one_at_a_time":
            return Listed(tuple(_one_at_a_time(spec, columns, conditions)))
    return Factorial(columns)


def _strata(spec: TaskSpec, seed: int) -> Iterator[Strata]:
    """Yield the columns of a Latin design, whose intervals are divided into strata."""
    for factor in spec.factors:
        if not factor.nuisance and not isinstance(factor.domain, Choices):
            if spec.plan.kind != "latin" or spec.plan.count is None:
                what = f"`{factor.name}` is a factor and so needs separate values"
                remedy = "only a Latin design takes a factor from an interval"
                raise SpecError(what, factor.place, remedy, code="WMS401")
            yield Strata(factor, spec.plan.count, (seed, spec.name, spec.plan.kind))


# ---------------------------------------------------------------- what is allowed


def _chains(spec: TaskSpec, conditions: Sequence[Constraint]) -> tuple[Column, ...]:
    """Return columns of the discrete factors; factors that share a condition form one column.

    Columns follow the order of the spec. Where combinations are sampled, they are sorted by name, so that the order of
    declarations does not change the draws.
    """
    domains = {f.name: f.domain.values for f in spec.factors if not f.nuisance and isinstance(f.domain, Choices)}
    if spec.plan.kind in ("sample", "latin", "groups"):
        domains = dict(sorted(domains.items()))
    try:
        columns = tuple(_tied_columns(domains, conditions))
    except TooManyCombinations as much:
        raise _too_many_combinations(much, conditions) from None
    constant = [c for c in conditions if not c.scope and not c.allowed]
    if constant or not all(c.size for c in columns):
        raise _nothing_left(domains, conditions)
    return columns


def _tied_columns(domains: Mapping[str, tuple[Level, ...]], conditions: Sequence[Constraint]) -> Iterator[Column]:
    """Yield the columns in the order of their first factors. Raises TooManyCombinations."""
    placed: set[str] = set()
    for name in domains:
        members = _closure({name}, [frozenset(c.scope) for c in conditions])
        here = [c for c in conditions if members & {*c.scope}]
        if name not in placed:
            tied = {n: values for n, values in domains.items() if n in members}
            yield Chain(tied, here) if here else FreeFactor(name, domains[name])
        placed |= members


def _closure(members: set[str], ties: Sequence[frozenset[str]]) -> set[str]:
    """Return the factors that conditions connect to `members`, directly or indirectly."""
    while True:
        wider = members.union(*(t for t in ties if t & members))
        if wider == members:
            return members
        members = wider


def _too_many_combinations(much: TooManyCombinations, conditions: Sequence[Constraint]) -> SpecError:
    """Return the error for conditions whose combinations are too many to count."""
    tying = {c.statement: c for c in conditions if len({*c.scope} & {*much.names}) > 1}
    first, *more = tying.values()
    names = f"{', '.join(much.names[:6])}{', ...' if len(much.names) > 6 else ''}"
    return SpecError(
        f"conditions tie {len(much.names)} factors together ({names}): {much.combinations:,} combinations to count at "
        f"once, and {MAX_COUNTED:,} are the most",
        first.place,
        "tie fewer factors to one another",
        code="WMS404",
        notes=tuple(Note(f"tied by this too: {c.text}", c.place) for c in more[:4]),
    )


def _nothing_left(domains: Mapping[str, tuple[Level, ...]], conditions: Sequence[Constraint]) -> SpecError:
    """Return the error that names a minimal set of conditions that leaves no combination."""
    by_require = {c.statement: c for c in reversed(conditions)}
    guilty = _smallest_conflict(
        sorted(by_require), lambda some: _is_satisfiable(domains, [c for c in conditions if c.statement in some])
    )
    first, *more = (by_require[i] for i in guilty)
    names = [n for n in domains if any(n in c.scope for c in conditions if c.statement in guilty)]
    whose = f"{'combination' if len(names) > 1 else 'value'} of {', '.join(names)}" if names else "instance"
    met = " and ".join(by_require[i].text for i in guilty)
    notes = tuple(Note("together with this", c.place) for c in more)
    remedy = "weaken a condition, or widen a domain"
    return SpecError(f"no {whose} meets {met}", first.place, remedy, code="WMS402", notes=notes)


def _is_satisfiable(domains: Mapping[str, tuple[Level, ...]], conditions: Sequence[Constraint]) -> bool:
    """Whether the conditions leave at least one combination."""
    if any(not c.scope and not c.allowed for c in conditions):
        return False
    try:
        return all(column.size for column in _tied_columns(domains, conditions))
    except TooManyCombinations:
        return True


def _smallest_conflict(candidates: Sequence[int], satisfiable: Callable[[set[int]], bool]) -> tuple[int, ...]:
    """Return the smallest unsatisfiable subset; a minimal one if there are more than MAX_SUBSETS candidates."""
    sets = chain.from_iterable(combinations(candidates, n) for n in range(1, len(candidates)))
    for some in islice(sets, MAX_SUBSETS):
        if not satisfiable(set(some)):
            return some
    needed = list(candidates)
    for one in candidates:
        if not satisfiable({*needed} - {one}):
            needed.remove(one)
    return tuple(needed)


# ---------------------------------------------------------------- one factor at a time


def _one_at_a_time(spec: TaskSpec, columns: Sequence[Column], conditions: Sequence[Constraint]) -> Iterator[Ranks]:
    """Yield the baseline, then the allowed combinations that differ from it in one factor, in the order of the spec."""
    baseline = _baseline(spec, conditions)
    ranks = _ranks(columns, baseline)
    if ranks is None:
        broken = next(c for c in conditions if not c.holds(baseline))
        where = format_levels(spec.factors, {name: baseline[name] for name in broken.scope})
        place = spec.plan.place or broken.place
        message, remedy = f"the baseline, with {where}, is excluded", "choose another value for it"
        raise SpecError(message, place, remedy, code="WMS408", notes=(Note("this condition", broken.place),))
    yield ranks
    for factor in spec.factors:
        for value in factor.domain.values if isinstance(factor.domain, Choices) and not factor.nuisance else ():
            varied = _ranks(columns, baseline | {factor.name: value})
            if value != baseline[factor.name] and varied is not None:
                yield varied


def _baseline(spec: TaskSpec, conditions: Sequence[Constraint]) -> dict[str, Level]:
    """Return the baseline: the named levels; otherwise the first value, or the first allowed conditional one."""
    levels: dict[str, Level] = {
        f.name: spec.plan.baseline.get(f.name, f.domain.values[0])
        for f in spec.factors
        if not f.nuisance and isinstance(f.domain, Choices)
    }
    for condition in conditions:
        name = condition.scope[0] if condition.conditional else ""
        if name and name not in spec.plan.baseline:
            choices = (value for value in condition.domains[name] if condition.holds(levels | {name: value}))
            levels[name] = next(choices, levels[name])
    return levels


def _ranks(columns: Sequence[Column], values: Mapping[str, Level]) -> Ranks | None:
    """Return the rank of a combination in each column, or None if a column excludes it."""
    ranks = [column.rank([values[n] for n in column.names]) for column in columns]
    return None if None in ranks else tuple(rank for rank in ranks if rank is not None)
