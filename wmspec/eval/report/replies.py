"""Replies from result files, joined with their questions; people's answers are merged by majority."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pandas as pd
import pyarrow as pa

from wmspec.core.diagnostics import WmsError, suggestion
from wmspec.core.parquet_io import open_parquet, read_table
from wmspec.core.places import FilePlace
from wmspec.core.safe_io import regular_file
from wmspec.dataset.build.images import image_format
from wmspec.eval.models.agreement import majority
from wmspec.eval.models.chance import chances
from wmspec.eval.models.results import files_of, upgraded, validated
from wmspec.eval.report.questions import Questions

#: Required columns of results; `docs/evaluate.md` describes them.
COLUMNS = (
    "id", "task", "dimension", "question_name", "engine", "index", "group", "model", "prompt", "ablation",
    "permutation", "sample", "order", "answer", "parsed", "right", "status", "cost", "tokens_in", "tokens_out", "text",
    "error",
)  # fmt: skip
#: Columns of open questions, which results of other programs may lack.
OPEN_COLUMNS = ("answer_number", "answer_unit", "answer_within")
#: Further columns of the results of clips.
CLIP_COLUMNS = (
    "nearest", "tempo", "frozen", "track_error", "final_error", "track_floor", "final_floor", "piq_spatial",
    "piq_spatiotemporal", "piq_weighted", "piq_mse", "miou", "background_rmse",
)  # fmt: skip
#: Columns that identify a reply.
KEY = ["id", "model", "prompt", "ablation", "permutation", "sample"]
#: Prefix of a person's name, and the name of all people together.
RATER_PREFIX, PEOPLE = "human:", "people"
#: Systems that check the pipeline and say nothing about the questions.
BASELINES = ("random", "blind", "options-only", "oracle")
#: Maximum number of systems: all pairs of them are compared.
MAX_SYSTEMS = 300
#: Minimum number of control groups for an interval over groups; below it instances are treated as independent.
MIN_GROUPS = 5


@dataclass(frozen=True)
class Replies:
    """All scored replies.

    `table` has a row for each, with the columns of results and: `system`; `cluster`, the unit of resampling; `right`, 1
    or 0; `skipped`, whether there is no answer (unparsed, truncated, refused or an error), which counts as wrong;
    `options`, their number; `query`, whether it is a companion question of a prediction task. `raters` has the replies
    of each person. `narrow` names the tasks with too few control groups, whose intervals are over instances.
    """

    table: pd.DataFrame
    raters: pd.DataFrame
    narrow: tuple[str, ...] = ()
    questions: Questions | None = None

    @cached_property
    def systems(self) -> tuple[str, ...]:
        """The systems by name, people last."""
        return tuple(sorted(self.table["system"].unique(), key=lambda s: (s == PEOPLE, s)))

    @property
    def models(self) -> tuple[str, ...]:
        """The systems except people and baselines."""
        return tuple(s for s in self.systems if s != PEOPLE and s not in BASELINES)

    @cached_property
    def scores(self) -> pd.DataFrame:
        """The share of right replies by question id (rows) and system (columns), NaN if there are none.

        Permutations and samples of a question count as one question.
        """
        return self._scores(self.table)

    @cached_property
    def parsed_scores(self) -> pd.DataFrame:
        """The scores of answered questions alone, as in the paper."""
        return self._scores(self.table[~self.table["skipped"]])

    def _scores(self, table: pd.DataFrame) -> pd.DataFrame:
        mean = table.groupby(["id", "system"], sort=True)["right"].mean().unstack("system")
        return mean.reindex(columns=list(self.systems))

    @cached_property
    def about(self) -> pd.DataFrame:
        """The attributes of every question, by id: `task`, `dimension`, `engine`, `cluster`, ... and `chance`.

        `chance` is the accuracy of guessing, NaN if unknown.
        """
        known = ["task", "dimension", "question_name", "engine", "index", "cluster", "options", "query"]
        first = self.table.drop_duplicates("id").set_index("id").sort_index()
        return first[known].assign(chance=_chances(first))

    @property
    def main_questions(self) -> pd.DataFrame:
        """`about` without companion questions, as in the tables of results."""
        return self.about[~self.about["query"]]


def read(paths: Sequence[Path], dataset: Path | None, names: Mapping[str, str] | None = None) -> Replies:
    """Read result files, or folders of them; `names` are display names of models.

    Raises WmsError if one cannot be read, lacks a column, or contradicts another, if a question is not in the dataset,
    or if there are too many systems.
    """
    table = pd.concat([_file(path) for path in files_of(paths)], ignore_index=True)
    if table.empty:
        raise WmsError("the results have no replies", help="evaluate again, with questions")
    table = _unique_replies(table)
    table = table.assign(model=table["model"].replace(_checked_names(table["model"], names or {})))
    questions = Questions.read(dataset) if dataset else None
    if questions is not None:
        _check_dataset(table, questions, dataset)
    made = replies(table, questions)
    if len(made.systems) > MAX_SYSTEMS:
        raise WmsError(
            f"the results are of {len(made.systems):,} systems, and a report compares at most {MAX_SYSTEMS}",
            help="give the results of fewer models",
        )
    return made


def replies(table: pd.DataFrame, questions: Questions | None = None) -> Replies:
    """Return replies from rows of results (`COLUMNS`)."""
    table = table.assign(
        system=_systems(table),
        cluster=_clusters(table),
        skipped=table["status"] != "answered",
        right=table["right"].eq(True).astype(float),
        options=table["order"].map(lambda order: 0 if order is None else len(order)),
        query=False if questions is None else table["id"].map(questions.table["query"]).astype(bool),
    )
    rated = table["model"].str.startswith(RATER_PREFIX)
    people = _majority(table[rated])
    whole = pd.concat([table[~rated], people], ignore_index=True).sort_values(["system", *KEY[:1], *KEY[4:]])
    return Replies(whole.reset_index(drop=True), table[rated], tuple(_narrow_tasks(table)), questions)


# ---------------------------------------------------------------- files


def _file(path: Path) -> pd.DataFrame:
    try:
        file = open_parquet(path)
        lacking = [name for name in COLUMNS if name not in file.schema_arrow.names]
        if lacking:
            raise WmsError(
                f"{path} is no file of results: it lacks the columns {', '.join(lacking)}; "
                "give what `wmspec evaluate` or `wmspec study collect` wrote (a dataset goes to --dataset)"
            )
        columns = [name for name in (*COLUMNS, *OPEN_COLUMNS, "finish_reason") if name in file.schema_arrow.names]
        table: pd.DataFrame = validated(upgraded(read_table(path, columns)), path).to_pandas()
        clips = [name for name in CLIP_COLUMNS if name in file.schema_arrow.names]
        return table.assign(**{name: read_table(path, [name])[name].to_pandas() for name in clips})
    except FileNotFoundError:
        raise WmsError(f"{path} is not there; give a file or a folder that `wmspec evaluate` wrote") from None
    except (OSError, pa.ArrowException) as error:
        reason = str(error).splitlines()[0]
        raise WmsError(
            f"cannot be read ({reason})", FilePlace(str(path)), "evaluate again, what was answered is kept"
        ) from None


#: The largest picture of film strips (bytes).
MAX_STRIPS = 20_000_000


def read_strips(paths: Sequence[Path]) -> dict[str, bytes]:
    """Return the film strips (PNG) beside result files, by the model's name; those that cannot be read are left out."""
    found = {}
    for path in files_of(paths):
        place = path.with_suffix(".strips.png")
        try:
            content = regular_file(place).read_bytes() if place.stat().st_size <= MAX_STRIPS else b""
        except OSError:
            continue
        if image_format(content) == "PNG":
            model = read_table(path, ["model"])["model"]
            found[str(model[0]) if len(model) else path.stem] = content
    return found


def _unique_replies(table: pd.DataFrame) -> pd.DataFrame:
    """Return every reply once. The same file may be given twice; two replies to one request are an error."""
    table = table.assign(said=table["parsed"].astype(str) + table["status"]).drop_duplicates([*KEY, "said"])
    twice = table[table.duplicated(KEY)]
    if len(twice):
        first = twice.iloc[0]
        raise WmsError(
            f"{len(twice):,} questions have two different replies of one model, such as {first['id']} of "
            f"{first['model']}; "
            "give one run of each model, or evaluate with several samples"
        )
    return table.drop(columns="said")


def _check_dataset(table: pd.DataFrame, questions: Questions, dataset: Path | None) -> None:
    strange = table.loc[~table["id"].isin(questions.table.index), "id"].unique()
    if len(strange):
        close = suggestion(str(strange[0]), map(str, questions.table.index[:1000]))
        raise WmsError(
            f"{len(strange):,} questions answered are not in {dataset}, such as {strange[0]}; "
            f"give the dataset that was evaluated{f' ({close})' if close.startswith('did') else ''}"
        )


def _checked_names(models: pd.Series[str], names: Mapping[str, str]) -> dict[str, str]:
    """Return display names by model. Raises WmsError for an unknown model, or for one name of two systems."""
    known = sorted(map(str, models.unique()))
    for id, name in names.items():
        if id not in known:
            hint = suggestion(id, known) or f"there are {', '.join(known[:10])}"
            raise WmsError(f"--name {id}={name}: there are no results of `{id}`; {hint}")
        if id in BASELINES or id.startswith(RATER_PREFIX):
            raise WmsError(f"--name {id}={name}: baselines and people keep their names")
        if not re.fullmatch(r"[^\x00-\x1f\x7f-\x9f]{1,60}", name):
            raise WmsError(f"--name {id}={name}: expected a name of 1 to 60 characters")
    shown = [names.get(id, id) for id in known]
    twice = [name for name in names.values() if shown.count(name) > 1 or name in (*BASELINES, PEOPLE)]
    if twice:
        raise WmsError(f"--name: two systems would be called {twice[0]}")
    return dict(names)


# ---------------------------------------------------------------- systems


def _clusters(table: pd.DataFrame) -> pd.Series[str]:
    """Return the control group; the instance in tasks with fewer than MIN_GROUPS (see `Replies.narrow`)."""
    instance = table["task"] + "/" + table["index"].astype(str)
    return table["group"].where(~table["task"].isin(_narrow_tasks(table)), instance)


def _narrow_tasks(table: pd.DataFrame) -> list[str]:
    groups = table.groupby("task")["group"].nunique()
    return sorted(map(str, groups.index[groups < MIN_GROUPS]))


def _systems(table: pd.DataFrame) -> pd.Series[str]:
    """Return the model's name, with its prompt and ablation where these differ between its replies."""
    name = table["model"].astype(str)
    several = table.groupby("model")["prompt"].transform("nunique") > 1
    name = name.where(~several, name + " · " + table["prompt"].astype(str))
    ablation = table["ablation"].fillna("").astype(str)
    name = name.where(ablation.isin(["", "none"]), name + " · " + ablation)
    return name.where(~table["model"].str.startswith(RATER_PREFIX), PEOPLE)


def _chances(questions: pd.DataFrame) -> pd.Series[float]:
    """Return the accuracy of guessing each question."""
    needed = questions.reindex(columns=["task", "question_name", "group", "options", *OPEN_COLUMNS])
    rows = needed.astype(object).where(needed.notna(), None).to_dict("records")
    found = chances({str(name): value for name, value in row.items()} for row in rows)
    return pd.Series(found, questions.index, dtype=float)


def _majority(rated: pd.DataFrame) -> pd.DataFrame:
    """Return one reply for each question: the choice of most raters. Ties are broken at random, seeded by the id."""
    if rated.empty:
        return rated
    chosen = [_vote(str(name), of_one) for name, of_one in rated.groupby("id", sort=True)]
    return rated.loc[chosen].assign(model=PEOPLE, sample=0, permutation=0)


def _vote(name: str, of_one: pd.DataFrame) -> int:
    """Return the row of a rater in the majority."""
    outcome = of_one["parsed"].astype(str) + of_one["right"].astype(str)
    return int(outcome.index[outcome == majority(name, outcome)].min())
