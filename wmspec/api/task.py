"""Tasks as sequences of instances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Unpack, overload

from wmspec.compile.design.depend import dependencies
from wmspec.compile.design.design import Design
from wmspec.compile.design.design import Instance as Drawn
from wmspec.compile.design.dimension import dimension
from wmspec.compile.design.levels import Level
from wmspec.compile.design.what_ifs import possible_what_ifs
from wmspec.core import wm_abench
from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.places import Source
from wmspec.lang.check.ir.ir import Choices, Counterfactual, Interval, TaskSpec
from wmspec.lang.check.ir.ir import Factor as DeclaredFactor

if TYPE_CHECKING:
    from pxr import Usd

    from wmspec.api.episode import Episode
    from wmspec.api.rendering import RenderOptions
    from wmspec.runtime.questions.model import QuestionRow, Rejected


@dataclass(frozen=True)
class Factor:
    """A factor or a nuisance. `values` and `bounds` are in the SI `unit`, which is "" for numbers without one.

    `values` is None for a continuous domain, `bounds` for a discrete one. `about` is its dimension: color, shape, size,
    position, material, world or other, as declared in the spec or derived from what it changes.
    """

    name: str
    unit: str
    nuisance: bool
    values: tuple[Level, ...] | None
    bounds: tuple[float, float] | None
    about: str = "other"

    @classmethod
    def of(cls, declared: DeclaredFactor, about: str) -> Factor:
        """Return a declaration as a factor with this dimension."""
        match declared.domain:
            case Choices(values=values):
                return cls(declared.name, declared.unit, declared.nuisance, values, None, about)
            case Interval(low=low, high=high):
                return cls(declared.name, declared.unit, declared.nuisance, None, (low, high), about)
            case normal:
                reach = 3 * normal.deviation
                bounds = (normal.mean - reach, normal.mean + reach)
                return cls(declared.name, declared.unit, declared.nuisance, None, bounds, about)


@dataclass(frozen=True, repr=False)
class Task(Sequence["Instance"]):
    """A checked task: the sequence of its instances, each built on access.

    `spec` is the checked task, `source` its text, `libraries` the texts of the libraries that it uses, `path` its file
    (None for a text), and `assets` the paths of other files that it names, such as meshes.
    """

    spec: TaskSpec
    source: Source
    libraries: Mapping[Path, Source]
    path: Path | None
    seed: int = 0
    assets: frozenset[Path] = frozenset()

    def __repr__(self) -> str:
        return f"<Task {self.name} from {self.file}>"

    @property
    def name(self) -> str:
        """The name of the task; columns and files use it."""
        return self.spec.name

    @property
    def dimension(self) -> str:
        """The tested dimension, such as `prediction.mechanistic.physics`."""
        return self.spec.dimension

    @property
    def title(self) -> str:
        """A description in one line."""
        return self.spec.title

    @property
    def file(self) -> str:
        """The name of the spec's file, as messages show it."""
        return str(self.path or self.source.name)

    @cached_property
    def design(self) -> Design:
        """The design. Raises WmsError if the spec allows none."""
        return Design(self.spec, self.seed)

    @property
    def factors(self) -> tuple[Factor, ...]:
        """The factors, in the order of the spec."""
        return tuple(Factor.of(f, dimension(self.spec, f)) for f in self.design.factors)

    @property
    def nuisances(self) -> tuple[Factor, ...]:
        """The nuisances, each drawn once per group."""
        return tuple(Factor.of(f, dimension(self.spec, f)) for f in self.design.nuisances)

    @property
    def questions(self) -> int:
        """The number of questions per instance."""
        return len(self.spec.questions)

    @property
    def counterfactuals(self) -> tuple[str, ...]:
        """The names of all counterfactuals, each with its question's number if several questions have counterfactuals.

        They include what-ifs, whose names describe the change, such as `without_ball`.
        """
        return tuple(self._changes)

    @property
    def groups(self) -> int:
        """The number of groups of instances that share every draw: the sample size of nuisances."""
        return self.design.draws

    @property
    def sample_sizes(self) -> dict[str, int]:
        """The number of independent groups for every factor and nuisance.

        For a factor that varies within groups, the number of these groups; otherwise that of all groups.
        """
        return self.design.sample_sizes

    @property
    def images(self) -> int:
        """The number of pictures of a question, without those of its options."""
        from wmspec.compile.layout.evaluator import Evaluator
        from wmspec.runtime.questions.views import views_of

        first = self.design[0]
        return len(views_of(self.spec, Evaluator(self.spec, first.values, None, first.key)))

    @property
    def paper(self) -> wm_abench.Column | None:
        """The task of WM-ABench (a column of its tables) that this task rebuilds, or None."""
        return wm_abench.COLUMN_OF_TASK.get(self.name)

    def sample(self, count: int) -> tuple[Instance, ...]:
        """Return `count` different instances in a random order that depends on the seed; at most all."""
        return tuple(self[index] for index in self.design.sample(count))

    def to_json(self, indent: int | None = 2) -> str:
        """Return the checked task as JSON; `wmspec schema` prints the schema."""
        from wmspec.lang.check.ir.record import to_json

        return to_json(self.spec, indent)

    def __len__(self) -> int:
        return len(self.design)

    @overload
    def __getitem__(self, index: int) -> Instance: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Instance, ...]: ...
    def __getitem__(self, index: int | slice) -> Instance | tuple[Instance, ...]:
        """Return an instance by index; negative indices count from the end. Raises IndexError."""
        if isinstance(index, slice):
            return tuple(self[i] for i in range(len(self))[index])
        return Instance(self, self.design[index + len(self) if index < 0 else index])

    def __iter__(self) -> Iterator[Instance]:
        return (self[i] for i in range(len(self)))

    @cached_property
    def _changes(self) -> dict[str, Counterfactual]:
        many = sum(bool(question.counterfactuals) for question in self.spec.questions) > 1
        named = {
            f"{change.name} ({number})" if many else change.name: change
            for number, question in enumerate(self.spec.questions, 1)
            for change in question.counterfactuals
        }
        depend = dependencies(self.spec)
        imagined = (change for question in self.spec.questions for change in possible_what_ifs(question, depend))
        return {change.name: change for change in imagined} | named

    def change(self, counterfactual: str) -> Counterfactual | None:
        """Return the counterfactual with this name; None for "". Raises WmsError if there is none."""
        if not counterfactual:
            return None
        if counterfactual not in self._changes:
            hint = suggestion(counterfactual, self._changes) or "it has none"
            raise WmsError(f"`{self.name}` has no counterfactual `{counterfactual}`; {hint}")
        return self._changes[counterfactual]


@dataclass(frozen=True, repr=False)
class Instance:
    """One combination of levels of a task's factors, with drawn nuisances."""

    task: Task
    drawn: Drawn

    def __repr__(self) -> str:
        return f"<Instance {self.index} of {self.task.name}: {self}>"

    def __str__(self) -> str:
        from wmspec.compile.design.levels import format_levels

        return format_levels(self.task.design.factors, self.factors)

    @property
    def index(self) -> int:
        """The index in the task."""
        return self.drawn.index

    @property
    def block(self) -> int:
        """The number of its group, within which only factors vary."""
        return self.drawn.block

    @property
    def factors(self) -> dict[str, Level]:
        """The level of every factor, in SI units."""
        return self.drawn.factors

    @property
    def nuisances(self) -> dict[str, Level]:
        """The value of every nuisance, in SI units."""
        return self.drawn.nuisances

    def redrawn(self, times: int) -> Instance:
        """Return the instance with group-level draws re-sampled; `times` selects the re-sample, 0 the original.

        Datasets with balanced answers contain some of these; their column `redrawn` has `times`. Raises WmsError if
        the design draws nothing per group.
        """
        try:
            return Instance(self.task, self.task.design.redrawn(times)[self.index])
        except IndexError as error:
            raise WmsError(f"{error}") from None

    def neighbors(self, factor: str) -> tuple[Instance, ...]:
        """Return the instances that differ in this factor only. Raises WmsError if there is no such factor."""
        if factor not in self.factors:
            raise WmsError(f"`{self.task.name}` has no factor `{factor}`; {suggestion(factor, self.factors)}")
        return tuple(self.task[index] for index in self.task.design.neighbours(self.index, factor))

    def stage(self, counterfactual: str = "") -> Usd.Stage:
        """Return the USD stage, in memory, of the instance or of a counterfactual.

        Raises WmsError with a place if a value is impossible, or if the stage cannot be executed.
        """
        from wmspec.compile.stage.episode import document
        from wmspec.compile.stage.layers import compose

        return compose(document(self.task.spec, self.drawn, self.task.change(counterfactual)))

    def write(self, folder: Path) -> list[Path]:
        """Write the stage into an existing folder: base layer, instance layer, counterfactual layers.

        Returns their paths. Raises WmsError if they cannot be written.
        """
        from wmspec.compile.stage.write import write_stages

        return write_stages(self.task.design, self.drawn, folder)

    def native(self, engine: str) -> dict[str, str]:
        """Return the scene in the engine's native format, file name -> text, usable without wmspec."""
        from wmspec.runtime.engines.registry import backend
        from wmspec.sim.usd import read

        return backend(engine).native(read(self.stage()))

    def run(
        self, engine: str, counterfactual: str = "", *, duration: float | None = None, strict: bool = False
    ) -> Episode:
        """Execute the instance, or a counterfactual, in an engine; `duration` (s) overrides the horizon.

        Raises WmsError if there is no such counterfactual or engine, or if the engine fails; with `strict`, also if the
        engine only approximates the scene.
        """
        from wmspec.api.episode import execute

        return execute(self.stage(counterfactual), engine, duration, strict=strict)

    def ask(self, engine: str, **options: Unpack[RenderOptions]) -> InstanceQuestions:
        """Execute the instance in an engine and return its questions; `options` are those of the renderer.

        If the options form a closed set, all instances of the set are executed; if one is rejected, none has questions.
        """
        from wmspec.api.episode import executor
        from wmspec.api.rendering import renderer_of
        from wmspec.runtime.questions.closed_sets import ask_complete
        from wmspec.runtime.questions.model import Rejected
        from wmspec.runtime.questions.runs import EnginePair

        pair = EnginePair(executor(engine), renderer_of(engine, **options))
        answers = ask_complete(self.task.design.redrawn(self.drawn.redrawn), self.index, pair)
        rejected = tuple(a for a in answers if isinstance(a, Rejected))
        return InstanceQuestions(tuple(a for a in answers if not isinstance(a, Rejected)), rejected)


@dataclass(frozen=True)
class InstanceQuestions(Sequence["QuestionRow"]):
    """The questions of an instance in one engine, as a sequence.

    `rejected` holds the rejected questions, each with `reason` and `detail`.
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
        """Return an accepted question by position."""
        return self.rows[index]
