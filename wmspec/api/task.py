"""A task as a sequence of instances, each of which can be staged, executed and asked about."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Unpack, overload

from wmspec.compile.design.design import Design
from wmspec.compile.design.design import Instance as Drawn
from wmspec.compile.design.levels import Level
from wmspec.core import wm_abench
from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.lang.check.ir.ir import Choices, Counterfactual, Interval, TaskSpec
from wmspec.lang.check.ir.ir import Factor as DeclaredFactor
from wmspec.lang.parse.load import Program

if TYPE_CHECKING:
    from pxr import Usd

    from wmspec.api.drawing import Drawing
    from wmspec.api.episode import Episode
    from wmspec.runtime.questions.model import QuestionRow, Rejected


@dataclass(frozen=True)
class Factor:
    """What varies: a factor, or a nuisance. Its `values` and their `bounds` are in the SI `unit`, "" for what has none.

    One of the two is None: `values` where it is drawn from a continuous domain, `bounds` where it is not.
    """

    name: str
    unit: str
    nuisance: bool
    values: tuple[Level, ...] | None
    bounds: tuple[float, float] | None

    @classmethod
    def of(cls, declared: DeclaredFactor) -> Factor:
        """As the spec declares it."""
        match declared.domain:
            case Choices(values=values):
                return cls(declared.name, declared.unit, declared.nuisance, values, None)
            case Interval(low=low, high=high):
                return cls(declared.name, declared.unit, declared.nuisance, None, (low, high))
            case normal:
                reach = 3 * normal.deviation
                bounds = (normal.mean - reach, normal.mean + reach)
                return cls(declared.name, declared.unit, declared.nuisance, None, bounds)


@dataclass(frozen=True, repr=False)
class Task(Sequence["Instance"]):
    """A checked task: the sequence of its instances, each built when it is asked for.

    `spec` is what was checked, `program` the text that it was read from, `path` its file (None for a text).
    """

    spec: TaskSpec
    program: Program
    path: Path | None
    seed: int = 0

    def __repr__(self) -> str:
        return f"<Task {self.name} from {self.file}>"

    @property
    def name(self) -> str:
        """Its name, by which its columns and files are called."""
        return self.spec.name

    @property
    def dimension(self) -> str:
        """What it tests, such as `prediction.mechanistic.physics`."""
        return self.spec.dimension

    @property
    def title(self) -> str:
        """One line about it."""
        return self.spec.title

    @property
    def file(self) -> str:
        """Where it was read from, as a person would say it."""
        return str(self.path or self.program.source.name)

    @cached_property
    def design(self) -> Design:
        """Its design. Raises WmsError where the spec allows none."""
        return Design(self.spec, self.seed)

    @property
    def factors(self) -> tuple[Factor, ...]:
        """What is studied, in the order of the spec."""
        return tuple(Factor.of(f) for f in self.design.factors)

    @property
    def nuisances(self) -> tuple[Factor, ...]:
        """What varies from block to block and is not studied."""
        return tuple(Factor.of(f) for f in self.design.nuisances)

    @property
    def questions(self) -> int:
        """How many questions are asked of each instance."""
        return len(self.spec.questions)

    @property
    def counterfactuals(self) -> tuple[str, ...]:
        """The names of what might have been instead; with a question's number where several questions have some."""
        return tuple(self._changes)

    @property
    def groups(self) -> int:
        """How many groups of instances there are that share every draw: the sample size that nuisances have."""
        return self.design.draws

    @property
    def sample_sizes(self) -> dict[str, int]:
        """Of every factor and nuisance, how many independent groups tell something about it.

        Of a factor that is crossed in groups these are the groups in which it is; of all else, all groups.
        """
        return self.design.sample_sizes

    @property
    def images(self) -> int:
        """How many pictures are shown with a question, before its options."""
        from wmspec.compile.layout.values import Values
        from wmspec.runtime.questions.views import views_of

        first = self.design[0]
        return len(views_of(self.spec, Values(self.spec, first.values, None, first.key)))

    @property
    def paper(self) -> wm_abench.Column | None:
        """The column of WM-ABench that it rebuilds, if it does."""
        return wm_abench.column(self.name)

    def sample(self, count: int) -> tuple[Instance, ...]:
        """So many different instances, in a random order that depends on the seed alone; all if there are fewer."""
        return tuple(self[index] for index in self.design.sample(count))

    def to_json(self, indent: int | None = 2) -> str:
        """The checked task as JSON, whose schema `wmspec schema` prints."""
        from wmspec.lang.check.ir.record import to_json

        return to_json(self.spec, indent)

    def __len__(self) -> int:
        return len(self.design)

    @overload
    def __getitem__(self, index: int) -> Instance: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Instance, ...]: ...
    def __getitem__(self, index: int | slice) -> Instance | tuple[Instance, ...]:
        """An instance by its index, from the end if that is negative. Raises IndexError outside the design."""
        if isinstance(index, slice):
            return tuple(self[i] for i in range(len(self))[index])
        return Instance(self, self.design[index + len(self) if index < 0 else index])

    def __iter__(self) -> Iterator[Instance]:
        return (self[i] for i in range(len(self)))

    @cached_property
    def _changes(self) -> dict[str, Counterfactual]:
        many = sum(bool(question.counterfactuals) for question in self.spec.questions) > 1
        return {
            f"{change.name} ({number})" if many else change.name: change
            for number, question in enumerate(self.spec.questions, 1)
            for change in question.counterfactuals
        }

    def change(self, counterfactual: str) -> Counterfactual | None:
        """The counterfactual of a name; None for none. Raises WmsError if there is none of that name."""
        if not counterfactual:
            return None
        if counterfactual not in self._changes:
            hint = suggestion(counterfactual, self._changes) or "it has none"
            raise WmsError(f"`{self.name}` has no counterfactual `{counterfactual}`; {hint}")
        return self._changes[counterfactual]


@dataclass(frozen=True, repr=False)
class Instance:
    """One combination of a task's factors, with its nuisances drawn."""

    task: Task
    drawn: Drawn

    def __repr__(self) -> str:
        return f"<Instance {self.index} of {self.task.name}: {self}>"

    def __str__(self) -> str:
        from wmspec.compile.design.describe import told

        return told(self.task.design.factors, self.factors)

    @property
    def index(self) -> int:
        """Its place in the task."""
        return self.drawn.index

    @property
    def block(self) -> int:
        """The repetition that it belongs to, within which nothing varies but the factors."""
        return self.drawn.block

    @property
    def factors(self) -> dict[str, Level]:
        """The value of every factor, SI units."""
        return self.drawn.factors

    @property
    def nuisances(self) -> dict[str, Level]:
        """The value of every nuisance, SI units."""
        return self.drawn.nuisances

    def redrawn(self, times: int) -> Instance:
        """The same with everything drawn anew that is drawn for its group, for the so-manieth time; 0 is itself.

        Where answers are balanced a dataset has some of these; its column `redrawn` says which. Raises WmsError if
        what the design draws is not drawn for groups.
        """
        try:
            return Instance(self.task, self.task.design.redrawn(times)[self.index])
        except IndexError as error:
            raise WmsError(f"{error}") from None

    def neighbors(self, factor: str) -> tuple[Instance, ...]:
        """The instances that differ from this one in that factor alone. Raises WmsError if there is no such factor."""
        if factor not in self.factors:
            raise WmsError(f"`{self.task.name}` has no factor `{factor}`; {suggestion(factor, self.factors)}")
        return tuple(self.task[index] for index in self.task.design.neighbours(self.index, factor))

    def stage(self, counterfactual: str = "") -> Usd.Stage:
        """The USD stage, in memory; of what it would be under a counterfactual, if one is named.

        Raises WmsError with its place if a value is impossible, or something cannot be executed.
        """
        from wmspec.compile.stage.episode import document
        from wmspec.compile.stage.layers import compose

        return compose(document(self.task.spec, self.drawn, self.task.change(counterfactual)))

    def write(self, folder: Path) -> list[Path]:
        """Write the stage into a folder that exists: the task's base layer, this instance's, its counterfactuals'.

        Returns their paths. Raises WmsError if it cannot be written.
        """
        from wmspec.compile.stage.write import write_stages

        return write_stages(self.task.design, self.drawn, folder)

    def native(self, engine: str) -> dict[str, str]:
        """The episode in an engine's own form, file name -> text, usable without wmspec."""
        from wmspec.runtime.engines.registry import backend
        from wmspec.sim.usd import read

        return backend(engine).native(read(self.stage()))

    def run(self, engine: str, counterfactual: str = "", *, duration: float | None = None) -> Episode:
        """Execute it in an engine, or what it would be under a counterfactual; for a `duration` (s) other than its own.

        Raises WmsError if there is no such scene, no such engine, or if the engine gives up on it.
        """
        from wmspec.api.episode import execute

        return execute(self.stage(counterfactual), engine, duration)

    def ask(self, engine: str, **drawing: Unpack[Drawing]) -> Asked:
        """Ask its questions of an engine's execution, with pictures by the same engine or another.

        Where the options are a closed set, its siblings are asked as well: if one of them fails, none is asked.
        """
        from wmspec.api.drawing import renderer_of
        from wmspec.api.episode import executor
        from wmspec.runtime.questions.closed_sets import ask_whole
        from wmspec.runtime.questions.model import Rejected
        from wmspec.runtime.questions.runs import EnginePair

        pair = EnginePair(executor(engine), renderer_of(engine, **drawing))
        answers = ask_whole(self.task.design.redrawn(self.drawn.redrawn), self.index, pair)
        rejected = tuple(a for a in answers if isinstance(a, Rejected))
        return Asked(tuple(a for a in answers if not isinstance(a, Rejected)), rejected)


@dataclass(frozen=True)
class Asked(Sequence["QuestionRow"]):
    """The questions of an instance in one engine: a sequence of those that can be asked.

    `rejected` are the others, each with its `reason` and `detail`: what went wrong is data.
    """

    rows: tuple[QuestionRow, ...]
    rejected: tuple[Rejected, ...]

    def __len__(self) -> int:
        return len(self.rows)

    @overload
    def __getitem__(self, index: int) -> QuestionRow: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[QuestionRow, ...]: ...
    def __getitem__(self, index: int | slice) -> QuestionRow | tuple[QuestionRow, ...]:
        """A question by its place among those that can be asked."""
        return self.rows[index]
