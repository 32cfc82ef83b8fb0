"""Collects people's answers as results: performance and agreement of raters, and their payment sheet."""

from __future__ import annotations

import csv
import io
import sqlite3
from collections import Counter, defaultdict
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

from wmspec import __version__
from wmspec.core.diagnostics import WmsError
from wmspec.core.places import FilePlace
from wmspec.eval import replies
from wmspec.eval.models import prompt, results
from wmspec.eval.models.agreement import alpha, majority
from wmspec.eval.models.model import Reply
from wmspec.eval.models.request import Ask
from wmspec.eval.study import answers, store
from wmspec.eval.study.answers import Visit
from wmspec.eval.study.model import Item, Study, load
from wmspec.eval.study.store import AnswerStore

#: Prefix of a person's name in the column `model`, and the name of the prompt.
RATER_PREFIX, PROMPT = "human:", "study"
#: Time below which an answer is too fast to be based on the pictures (s).
MIN_SECONDS = 1.0


@dataclass(frozen=True)
class Rater:
    """The performance of one person, with the ids of the site that invited them, if any.

    `answered` of `steps`, `checks_passed` of the attention `checks`, `right` of `questions`. `seconds` is the median
    time of an answer, `hasty` the share below HASTY, `away` the time with the page hidden (s), `minutes` the time of
    all answers.
    """

    rater: str
    slot: int
    code: str
    answered: int
    steps: int
    checks_passed: int
    checks: int
    right: int
    questions: int
    seconds: float | None
    hasty: float
    away: float
    minutes: float
    counted: bool
    study_id: str = ""
    session_id: str = ""


@dataclass(frozen=True)
class Agreement:
    """Raters' choices on a task's questions with options (or on all), Krippendorff's α, the majority's accuracy."""

    task: str
    questions: int
    choices: int
    alpha: float | None
    majority: float


@dataclass(frozen=True)
class StudyResult:
    """The result of a study; `missing` is the number of replies that its design still lacks."""

    raters: tuple[Rater, ...]
    agreement: tuple[Agreement, ...]
    replies: int
    missing: int


def collect(folder: Path, files: Sequence[Path], output: Path, least_checks: float = 0.0) -> StudyResult:
    """Write the results of a study, from its server's file and from saved files. The first answer to a step counts.

    Raters who passed a smaller share of attention checks than `least_checks` are reported and excluded. Raises WmsError
    if a file belongs to another study, or if `output` holds anything but results.
    """
    study = load(folder)
    if output.exists():
        results.read(output)
    visits = _visits(study, folder, files)
    if not any(visit.answers for visit in visits):
        raise WmsError(f"{folder} has no answers yet; give the files that its page gave, or `wmspec study serve` it")
    named = _visits_by_name(visits)
    raters = tuple(_rater(study, visit, name, least_checks) for name, visit in named.items())
    rows = [row for rater in raters if rater.counted for row in _rows(study, named[rater.rater], rater.rater)]
    places = {item.id: place for place, item in enumerate(study.items)}
    rows.sort(key=lambda row: (places[row["id"]], row["model"]))
    expected = sum(item.kind == "question" for item in study.items) * study.raters
    enough = sum(min(count, study.raters) for count in Counter(row["id"] for row in rows).values())
    collected = StudyResult(raters, tuple(_agreement(rows)), len(rows), expected - enough)
    results.write(output, rows, _about(study, rows, collected))
    return collected


def _visits(study: Study, folder: Path, files: Sequence[Path]) -> list[Visit]:
    """Return the visits of all sources, one for each session."""
    served = folder / store.ANSWERS_FILE
    all_visits: list[Visit] = []
    if served.exists():
        try:
            opened = AnswerStore(served, study)
            all_visits += opened.visits()
            opened.close()
        except (sqlite3.Error, ValueError) as error:
            raise WmsError(f"cannot be read ({error})", FilePlace(str(served)), "take it from a copy") from None
    all_visits += [answers.read(path, study) for path in files]
    visits: dict[str, Visit] = {}
    for visit in all_visits:
        before = visits.setdefault(visit.session, visit)
        if before.slot != visit.slot:
            raise WmsError(f"two files of answers say different things of the visit {visit.session[:8]}")
        known = {answer.step: answer for answer in (*reversed(visit.answers), *reversed(before.answers))}
        whole = tuple(known[step] for step in sorted(known))
        visits[visit.session] = before.model_copy(update={"answers": whole, "code": before.code or visit.code})
    return list(visits.values())


def _visits_by_name(visits: Iterable[Visit]) -> dict[str, Visit]:
    """Return visits by the rater's name: that of the link, else a unique prefix of the session id."""
    visits = sorted((visit for visit in visits if visit.answers), key=lambda visit: visit.session)
    count = Counter(visit.rater for visit in visits)
    long = {visit.session: f"{visit.rater}-{visit.session[:8]}".strip("-") for visit in visits}
    return {visit.rater if visit.rater and count[visit.rater] == 1 else long[visit.session]: visit for visit in visits}


def _answered_items(study: Study, visit: Visit) -> Iterable[tuple[answers.Answer, Item, int]]:
    for answer in visit.answers:
        shown = study.step(visit.slot, answer.step)
        if shown is not None:
            yield (answer, *shown)


def _rater(study: Study, visit: Visit, name: str, least_checks: float) -> Rater:
    by_kind = defaultdict(list)
    for answer, item, permutation in _answered_items(study, visit):
        by_kind[item.kind].append((answer, item, permutation))
    passed = sum(item.is_right(answer.text, permutation) for answer, item, permutation in by_kind["check"])
    seconds = [answer.seconds for answer, _, _ in by_kind["question"]]
    rows = _rows(study, visit, name)
    return Rater(
        rater=name,
        slot=visit.slot + 1,
        code=visit.code,
        answered=len(visit.answers),
        steps=len(study.slots[visit.slot]),
        checks_passed=passed,
        checks=len(by_kind["check"]),
        right=sum(row["right"] for row in rows),
        questions=len(rows),
        seconds=median(seconds) if seconds else None,
        hasty=sum(s < MIN_SECONDS for s in seconds) / len(seconds) if seconds else 0.0,
        away=sum(answer.away for answer in visit.answers),
        minutes=sum(answer.seconds for answer in visit.answers) / 60,
        study_id=visit.study_id,
        session_id=visit.session_id,
        counted=passed >= least_checks * len(by_kind["check"]),
    )


def _rows(study: Study, visit: Visit, name: str) -> list[results.Row]:
    """Return the scored rows of one person's answers."""
    template = prompt.load("default")  # letters for all options, as on the page
    made = []
    for answer, item, permutation in _answered_items(study, visit):
        if item.kind == "question":
            text = answer.text if item.options else f"{answer.text} {item.shown_unit}".rstrip()
            reply = Reply(text=text, seconds=answer.seconds)
            row = results.row(Ask(item.question(), template, permutation), reply, f"{RATER_PREFIX}{name}", PROMPT)
            made.append(row | {"prompt_hash": study.fingerprint})
    return made


def _agreement(rows: Sequence[results.Row]) -> Iterable[Agreement]:
    tasks: dict[str, dict[str, list[results.Row]]] = {}
    for row in rows:
        if row["options"]:
            tasks.setdefault(row["task"], {}).setdefault(row["id"], []).append(row)
    everything = {id: of_one for questions in tasks.values() for id, of_one in questions.items()}
    for name, questions in (*tasks.items(), *((("", everything),) if len(tasks) > 1 else ())):
        chosen = {id: [row["parsed"] for row in of_one] for id, of_one in questions.items()}
        right = [majority(id, places) == questions[id][0]["answer"] for id, places in chosen.items()]
        yield Agreement(
            task=name,
            questions=len(chosen),
            choices=sum(map(len, chosen.values())),
            alpha=alpha(_by_format(questions)),
            majority=sum(right) / len(right),
        )


def _by_format(questions: dict[str, list[results.Row]]) -> dict[Hashable, list[list[int]]]:
    """Return the choices of every question by format: task, question name, kind and number of options.

    The categories of a format are the options in words in alphabetical order, or the pictures in the dataset's order.
    """
    formats: dict[Hashable, list[list[int]]] = {}
    for rows in questions.values():
        options = rows[0]["options"]
        in_words = None not in options
        rank = {place: n for n, place in enumerate(sorted(range(len(options)), key=lambda p: options[p] or ""))}
        key = (rows[0]["task"], rows[0]["question_name"], in_words, len(options))
        formats.setdefault(key, []).append([rank[row["parsed"]] for row in rows if row["parsed"] is not None])
    return formats


def _about(study: Study, rows: Sequence[results.Row], collected: StudyResult) -> dict[str, Any]:
    """Return the content of the settings file."""
    counted = results.counts(rows)
    return {
        "format": 1,
        "asked": {"dataset": study.dataset, "study": study.fingerprint, "seed": study.seed, "prompt": PROMPT},
        "dataset": {"name": study.title},
        "versions": {"wmspec": __version__},
        "parser": replies.PARSER_VERSION,
        "replies": counted.replies,
        "right": counted.right,
        "status": counted.status,
        "missing": collected.missing,
        "raters": [asdict(rater) for rater in collected.raters],
        "agreement": [asdict(agreement) for agreement in collected.agreement],
    }


#: The columns, in order.
COLUMNS = (
    "rater", "study_id", "session_id", "code", "answered", "steps", "checks_passed", "checks", "minutes", "verdict",
)  # fmt: skip


def verdict(rater: Rater) -> str:
    """Return `pay` for a person who answered everything and whose checks suffice, else `incomplete` or `look`."""
    if rater.answered < rater.steps:
        return "incomplete"
    return "pay" if rater.counted else "look"


def payments(raters: Sequence[Rater]) -> str:
    """Return the sheet as CSV, in the order of raters."""
    text = io.StringIO()
    out = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    out.writeheader()
    for rater in raters:
        known = {name: getattr(rater, name) for name in COLUMNS if name not in ("minutes", "verdict")}
        out.writerow({**known, "minutes": f"{rater.minutes:.1f}", "verdict": verdict(rater)})
    return text.getvalue()
