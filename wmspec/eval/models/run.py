"""Runs: the requests of an evaluation, those still without a reply, and the results."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from wmspec import __version__
from wmspec.core.code_digest import installed_version
from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build import files
from wmspec.dataset.build.reader import DatasetReader
from wmspec.eval import replies
from wmspec.eval.models import results
from wmspec.eval.models.ablation import Ablation, applies
from wmspec.eval.models.causes import Cause, causes
from wmspec.eval.models.journal import Journal, Replies, require_same_settings
from wmspec.eval.models.limits import Limits, Meter, RateLimiter
from wmspec.eval.models.model import Model, Reply
from wmspec.eval.models.prompt import Prompt
from wmspec.eval.models.question import Question, Selection, questions
from wmspec.eval.models.request import Ask
from wmspec.eval.models.results import Counts

#: What an ablation needs.
_NEEDS = {"options": "options in words", "wording": "options in words for which there are others"}

#: Called after every reply with the number of right replies, the number of replies, and the cost.
Progress = Callable[[int, int, float], None]


@dataclass(frozen=True)
class Settings:
    """The settings that determine the requests; two runs with equal settings share their replies."""

    model: str
    prompt_name: str
    prompt: Prompt
    address: str | None = None
    ablation: Ablation | None = None
    seed: int = 0
    parameters: tuple[tuple[str, Any], ...] = ()
    images: str | None = None
    structured: bool = False


@dataclass(frozen=True)
class Run:
    """The questions of a run, with every circular permutation of the options if `permute`, and `samples` of each."""

    dataset: DatasetReader
    settings: Settings
    selection: Selection
    permute: bool = False
    samples: int = 1
    limits: Limits = field(default_factory=Limits)

    def settings_record(self) -> dict[str, Any]:
        """The settings as JSON values, with the digest of the dataset's manifest. Contains no secret."""
        settings = self.settings
        return {
            "dataset": files.digest(self.dataset.folder / files.MANIFEST),
            "model": settings.model,
            "base_url": settings.address,
            "prompt": settings.prompt_name,
            "prompt_hash": settings.prompt.hash,
            "ablation": settings.ablation,
            "parameters": dict(settings.parameters),
            "seed": settings.seed,
            "images": settings.images,
        } | ({"structured": True} if settings.structured else {})

    def chosen(self) -> list[Question]:
        """Return the questions to which the ablation applies, without pictures.

        Raises WmsError if the dataset lacks a task or engine, or if the ablation applies to none of its questions.
        """
        ablation = self.settings.ablation
        found = list(questions(self.dataset, self.selection.ids(self.dataset), pictures=False))
        chosen = [question for question in found if applies(question, ablation)]
        if found and not chosen:
            raise WmsError(f"--ablate {ablation}: no question has {_NEEDS.get(str(ablation), 'options')}")
        return chosen

    def first(self) -> Ask | None:
        """Return the first request, with pictures; None if there is none."""
        for question in questions(self.dataset, [question.id for question in self.chosen()[:1]]):
            return next(self.asks(question))
        return None

    def asks(self, question: Question) -> Iterator[Ask]:
        """Yield all requests of a question."""
        turns = len(question.options) if self.permute and question.options else 1
        for permutation in range(turns):
            for sample in range(self.samples):
                yield Ask(question, self.settings.prompt, permutation, sample, self.settings.ablation)


@dataclass(frozen=True)
class RunResult:
    """The end of a run: the counts of all results, and the number of requests left out because of a limit.

    `causes` are those of replies without an answer, `notes` say how requests were changed for the server.
    """

    counts: Counts
    missing: int
    causes: tuple[Cause, ...] = ()
    notes: tuple[str, ...] = ()


def evaluate(run: Run, model: Model, output: Path, progress: Progress) -> RunResult:
    """Send the requests without a reply and write results to `output`, resuming an interrupted run.

    Raises WmsError if the run cannot go on. Replies are kept, and the same run resumes from them.
    """
    results.check_free(output)
    settings_record, chosen = run.settings_record(), run.chosen()
    with Journal(output.with_suffix(".journal.jsonl"), settings_record) as journal:
        have = _existing_replies(output, settings_record) | journal.replies
        _ask(run, model, chosen, have, journal, progress)
        requested = {ask.key for question in chosen for ask in run.asks(question)}
        rows = list(_rows(run, have))
        missing = sum(key not in have for key in requested)
        results.write(output, rows, _about(run, settings_record, rows, missing) | {"notes": list(model.notes)})
        journal.discard()
    return RunResult(results.counts(rows), missing, causes(rows), model.notes)


def _existing_replies(output: Path, settings_record: dict[str, Any]) -> Replies:
    """Return the replies in existing results."""
    if not output.exists():
        return {}
    rows, about = results.read(output)
    require_same_settings(about.get("asked"), settings_record, output)
    return results.replies_of(rows)


def _ask(run: Run, model: Model, chosen: list[Question], have: Replies, journal: Journal, progress: Progress) -> None:
    """Send all requests without a reply, several at a time; replies are added to `have`."""
    meter = Meter(run.limits, spent=sum(reply.cost or 0.0 for reply in have.values()))
    pace = RateLimiter(run.limits.a_minute)
    right = total = 0

    def one(ask: Ask) -> Reply:
        pace.wait()
        return model.reply(ask)

    def settle(ready: Iterable[Future[Reply]]) -> None:
        nonlocal right, total
        for future in ready:
            ask, reply = flying.pop(future), future.result()
            journal.keep(ask.key, reply)
            have[ask.key] = reply
            total += 1
            right += results.row(ask, reply, "", "")["right"]
            progress(right, total, meter.spent + (reply.cost or 0.0))
            meter.receive(reply)

    flying: dict[Future[Reply], Ask] = {}
    pool = ThreadPoolExecutor(model.asks, thread_name_prefix="ask")
    try:
        for ask in _pending_asks(run, chosen, have):
            while len(flying) >= model.asks or (flying and not meter.may_send()):
                settle(wait(flying, return_when=FIRST_COMPLETED).done)
            if not meter.may_send():
                break
            meter.send()
            flying[pool.submit(one, ask)] = ask
        while flying:
            settle(wait(flying, return_when=FIRST_COMPLETED).done)
    except Exception:
        wait(flying)  # pending requests are already paid for
        _save_arrived(flying, journal)
        raise
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _save_arrived(flying: dict[Future[Reply], Ask], journal: Journal) -> None:
    """Save the replies that arrived while another request failed."""
    for future, ask in flying.items():
        if future.exception() is None:
            journal.keep(ask.key, future.result())


def _pending_asks(run: Run, chosen: list[Question], have: Replies) -> Iterator[Ask]:
    """Yield the requests without a reply, in order; the pictures of few questions are in memory at a time."""

    def wanting(question: Question) -> list[Ask]:
        return [ask for ask in run.asks(question) if ask.key not in have or have[ask.key].failed]

    pending = {question.id for question in chosen if wanting(question)}
    for question in questions(run.dataset, pending):
        yield from wanting(question)


def _rows(run: Run, have: Replies) -> Iterator[results.Row]:
    """Yield the rows of all replies in dataset order, then by permutation and sample."""
    turns: dict[str, list[tuple[int, int]]] = {}
    for id, permutation, sample in have:
        turns.setdefault(id, []).append((permutation, sample))
    settings = run.settings
    for question in questions(run.dataset, turns, pictures=False):
        first = Ask(question, settings.prompt, ablation=settings.ablation)
        for permutation, sample in sorted(turns[question.id]):
            ask = replace(first, permutation=permutation, sample=sample)
            yield results.row(ask, have[ask.key], settings.model, settings.prompt_name)


def _about(run: Run, settings_record: dict[str, Any], rows: list[results.Row], missing: int) -> dict[str, Any]:
    """Return the content of the settings file."""
    counted = results.counts(rows)
    manifest = run.dataset.manifest
    template = run.settings.prompt.model_dump(mode="json")
    installed = {name: v for name in ("openai", "transformers", "torch") if (v := installed_version(name))}
    return {
        "format": 1,
        "asked": settings_record,
        "template": template,
        "permute": run.permute,
        "samples": run.samples,
        "dataset": {key: manifest[key] for key in ("rows", "engines", "seed", "size", "consensus", "versions")},
        "model_versions": sorted({row["model_version"] for row in rows if row["model_version"]}),
        "versions": {"wmspec": __version__, "python": platform.python_version()} | installed,
        "parser": replies.PARSER_VERSION,
        "replies": counted.replies,
        "right": counted.right,
        "status": counted.status,
        "missing": missing,
        "questions": hashlib.sha256("\n".join(row["id"] for row in rows).encode()).hexdigest()[:12],
    }
