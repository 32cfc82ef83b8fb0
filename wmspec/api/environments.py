"""Environments for reinforcement learning: fresh questions of a task, and rewards of replies."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import Image

from wmspec.api.loading import load
from wmspec.api.task import Task
from wmspec.compile.design.design import Design
from wmspec.compile.layout.evaluator import Evaluator
from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.rng import bits
from wmspec.dataset.build.rows import encode
from wmspec.dataset.build.splits import parse_split
from wmspec.eval.models import prompt as prompts
from wmspec.eval.models.question import question as read_question
from wmspec.eval.models.request import Ask, Picture, Text
from wmspec.eval.replies import mark
from wmspec.lang.check.expressions.measured import is_measured
from wmspec.lang.check.ir.evaluate import evaluate
from wmspec.lang.check.ir.ir import Factor, Level
from wmspec.runtime.engines.registry import select_backends
from wmspec.runtime.questions.verbalize import format_expression

if TYPE_CHECKING:
    from wmspec.eval.replies.mark import Mark

#: The number of instances from which ranks of difficulty are computed.
RANKED = 500
#: The number of instances in a row that may be rejected.
MAX_REJECTED = 200


@dataclass(frozen=True, repr=False)
class Problem:
    """A question as a model receives it, with the reward of a reply.

    `levels` are those of the instance's factors.
    """

    ask: Ask
    levels: Mapping[str, Level]

    def __repr__(self) -> str:
        return f"<Problem {self.id}>"

    @property
    def id(self) -> str:
        """The id of the question."""
        return self.ask.question.id

    @property
    def images(self) -> list[Image.Image]:
        """The pictures of the request, in order (RGB)."""
        pictures = (part.content for part in self.ask.request.parts if isinstance(part, Picture))
        return [Image.open(io.BytesIO(content)).convert("RGB") for content in pictures]

    @property
    def messages(self) -> list[dict[str, Any]]:
        """The request as messages of chat completions, with pictures as data URLs."""
        return self._messages(
            lambda png: {
                "type": "image_url",
                "image_url": {"url": f"data:image/png;base64,{base64.b64encode(png).decode()}"},
            }
        )

    @property
    def chat(self) -> list[dict[str, Any]]:
        """The request as messages of chat templates of transformers, with `{"type": "image"}` for each of `images`."""
        return self._messages(lambda _: {"type": "image"})

    def _messages(self, picture: Callable[[bytes], dict[str, Any]]) -> list[dict[str, Any]]:
        request = self.ask.request
        content = [
            {"type": "text", "text": part.text} if isinstance(part, Text) else picture(part.content)
            for part in request.parts
        ]
        system = [{"role": "system", "content": [{"type": "text", "text": request.system}]}] if request.system else []
        return [*system, {"role": "user", "content": content}]

    @property
    def truth(self) -> dict[str, Any]:
        """The data with which replies are marked (truth, tolerance), as JSON values."""
        return self.ask.truth

    @property
    def answer(self) -> str:
        """The right reply: a label, or a number with its unit."""
        return self.ask.true_reply

    def mark(self, reply: str, finish: str | None = None) -> Mark:
        """Return the outcome and score of a reply; `finish` is the reason for which the model stopped."""
        return mark(reply, **self.truth, finish=finish)

    def reward(self, reply: str, finish: str | None = None) -> float:
        """Return 1.0 for a right reply and 0.0 for every other."""
        return float(self.mark(reply, finish).right)


class Environment:
    """An endless stream of questions of a task, each executed when it is sampled.

    Instances come in a random order without repetition. When all were sampled, the design is drawn again with the next
    seed. Instances without a question are skipped.
    """

    def __init__(
        self, task: Task, allowed: Callable[[Design], Callable[[int], bool]], engine: str, prompt: prompts.Prompt
    ) -> None:
        self.task = task
        self.engine = engine
        self.prompt = prompt
        self._allowed = allowed
        self._problems = self._stream()
        self._current: Problem | None = None

    def __iter__(self) -> Iterator[Problem]:
        """Iterate over questions, without an end."""
        return self._problems

    def sample(self, count: int = 1) -> list[Problem]:
        """Return the next questions. Raises WmsError if no instance has a question."""
        return [next(self._problems) for _ in range(count)]

    def reset(self, seed: int | None = None) -> Problem:
        """Begin an episode, which has one question, and return it; `seed` restarts the stream.

        Raises WmsError if no instance has a question.
        """
        if seed is not None:
            self.task = replace(self.task, seed=seed)
            self._problems = self._stream()
        self._current = next(self._problems)
        return self._current

    def step(self, reply: str, finish: str | None = None) -> tuple[float, Mark]:
        """Return the reward of a reply and its mark, and end the episode. Raises WmsError before `reset`."""
        if self._current is None:
            raise WmsError("no question is open", help="call `reset` first")
        problem, self._current = self._current, None
        marked = problem.mark(reply, finish)
        return float(marked.right), marked

    def _stream(self) -> Iterator[Problem]:
        task, rejected, reason = self.task, 0, ""
        while True:
            for instance in map(task.__getitem__, task.design.sample(len(task), self._allowed(task.design))):
                questions = instance.ask(self.engine)
                for row in questions:
                    rejected = 0
                    question = read_question(encode(row, "questions"))
                    shift = bits("environment", question.id) % max(1, len(question.options))
                    yield Problem(Ask(question, self.prompt, permutation=shift), instance.factors)
                if not questions:
                    rejected, reason = (
                        rejected + 1,
                        "; ".join(f"{r.reason}: {r.detail}" for r in questions.rejected[:1]),
                    )
                if rejected >= MAX_REJECTED:
                    raise WmsError(f"`{task.name}`: {rejected} instances in a row have no question, such as {reason}")
            task = replace(task, seed=task.seed + 1)


def environment(
    task: Task | str | PathLike[str],
    *,
    difficulty: tuple[float, float] = (0.0, 1.0),
    levels: Mapping[str, Sequence[float | bool | str]] | None = None,
    split: str = "",
    shares: str = "",
    engine: str = "",
    prompt: str = "default",
    seed: int = 0,
) -> Environment:
    """Return an environment for reinforcement learning on a task.

    Args:
        task: a task, or the path of a spec of one task.
        difficulty: the range of ranks to keep, from 0 (easiest) to 1 (hardest); the spec's `difference` ranks.
        levels: only these levels of factors, by factor (SI; named levels by their names).
        split: only instances of "train", "validation" or "test", the first two without the hold-outs of the spec.
        shares: percent of each split, such as "train=80,validation=10,test=10".
        engine: the engine that executes and draws; by default the first that is installed.
        prompt: the prompt, such as "default" or "numbers", or a file.
        seed: the first random seed of a task given by path.

    Raises:
        WmsError: the spec has mistakes, an option does not fit the task, or no instance is left.
    """
    chosen = task if isinstance(task, Task) else load(task, seed=seed)
    if not chosen.questions:
        raise WmsError(f"the task `{chosen.name}` has no question")
    expected = {name: _level_set(chosen, name, among) for name, among in (levels or {}).items()}
    part = parse_split(split, shares)
    low, high = difficulty
    if not 0 <= low < high <= 1:
        raise WmsError("difficulty: expected two numbers from 0 (easiest) to 1 (hardest)")
    ranked = _Ranks(chosen) if difficulty != (0.0, 1.0) else None

    def allowed(design: Design) -> Callable[[int], bool]:
        inside = part.contains(design) if part else None

        def test(index: int) -> bool:
            if inside is not None and not inside(index):
                return False
            instance = design[index]
            if any(instance.factors[name] not in among for name, among in expected.items()):
                return False
            return ranked is None or low <= ranked.rank(design, index) <= high

        return test

    if not any(map(allowed(chosen.design), range(len(chosen)))):
        raise WmsError(f"`{chosen.name}`: no instance has this split, these levels and this difficulty")
    (name, *_) = select_backends(engine or "all")
    return Environment(chosen, allowed, name, prompts.load(prompt))


def _level_set(task: Task, name: str, levels: Sequence[float | bool | str]) -> set[Level]:
    """Return levels of a factor. Raises WmsError for others."""
    factors = {factor.name: factor for factor in task.design.factors}
    if name not in factors:
        raise WmsError(f"levels: `{task.name}` has no factor `{name}`; {suggestion(name, factors)}".rstrip("; "))
    known = _levels_by_word(factors[name])
    if unknown := [level for level in levels if level not in known]:
        words = ", ".join(map(str, known))
        raise WmsError(f"levels: {unknown[0]!r} is no level of `{name}`, which has {words}")
    return {known[level] for level in levels}


def _levels_by_word(factor: Factor) -> dict[Any, Level]:
    values = getattr(factor.domain, "values", ())
    return {factor.called(value) or value: value for value in values}


class _Ranks:
    """Ranks of instances by the strength of their stimulus: 0 is the strongest, 1 the weakest."""

    def __init__(self, task: Task) -> None:
        strengths = [q.difference for q in task.spec.questions if q.difference is not None]
        known = [each.value for each in strengths if not is_measured(task.spec, each.value)]
        if not known:
            raise WmsError(
                f"`{task.name}` has no `difference` that follows from factors and nuisances, so its instances have no "
                "difficulty before they are executed",
                help="choose them by `levels`",
            )
        self._expression = known[0]
        self._is_ratio = " / " in format_expression(self._expression)
        sampled = (self.strength(task.design, index) for index in task.design.sample(RANKED))
        self._sorted = np.sort(np.fromiter(sampled, dtype=float))

    def strength(self, design: Design, index: int) -> float:
        """Return the strength of an instance's stimulus; that of a ratio is its distance from 1."""
        instance = design[index]
        value = float(evaluate(self._expression, Evaluator(design.spec, instance.values, None, instance.key)))
        return abs(float(np.log(abs(value) or 1.0))) if self._is_ratio else abs(value)

    def rank(self, design: Design, index: int) -> float:
        """Return the rank of an instance, from 0 to 1: the middle one of all that are as strong."""
        strength = self.strength(design, index)
        weaker = (np.searchsorted(self._sorted, strength, side=side) for side in ("left", "right"))
        return 1.0 - sum(map(float, weaker)) / (2 * len(self._sorted))
