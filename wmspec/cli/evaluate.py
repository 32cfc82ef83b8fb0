"""`wmspec evaluate`: evaluate a model on a dataset."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wmspec.api.progress import progress_bar
from wmspec.cli.common import exit_if_failed, json_option, limit_option, seed_option, split_options, tell
from wmspec.core.diagnostics import WmsError
from wmspec.core.tally import Tally

if TYPE_CHECKING:
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.models.question import Selection
    from wmspec.eval.models.request import Ask
    from wmspec.eval.models.results import Counts
    from wmspec.eval.models.run import Run, RunResult
    from wmspec.eval.models.server import Server

_PATH = click.Path(path_type=Path)
#: Default request parameters. A server that rejects one is sent another (`wmspec.eval.models.message`).
_DEFAULTS: dict[str, Any] = {"temperature": 0, "max_tokens": 1024}
#: Prefix of clips among models.
CLIPS = "clips:"
#: Prefixes of latent models and of tables of their surprises.
SURPRISES = ("surprise:", "surprises:")


@click.command("evaluate")
@click.argument("dataset", type=_PATH, required=False)
@click.option(
    "--model",
    "-m",
    metavar="MODEL",
    help="openai:NAME, hf:PATH, clips:FOLDER, surprise:PACKAGE:FUNCTION, random, blind, options-only or oracle.",
)
@click.option("--output", "-o", type=_PATH, metavar="FILE", help="Results file (.parquet); an existing one is resumed.")
@click.option(
    "--base-url", metavar="URL", help="URL of an OpenAI-compatible server.  [default: OPENAI_BASE_URL, or OpenAI]"
)
@click.option(
    "--prompt",
    help="default, frames, clip, montage, numbers, paper, or a file.  [default: frames for films, else default]",
)
@click.option(
    "--ablate",
    type=click.Choice(["pictures", "question", "truth", "options", "wording"]),
    help="Omit all pictures, all but the options, the true option, or all options; or reword the options.",
)
@click.option(
    "--structured", is_flag=True, help="Constrain answers to the labels by a JSON schema, if the server offers it."
)
@click.option("--permute", is_flag=True, help="Ask once per cyclic permutation of the options.")
@click.option("--samples", type=click.IntRange(1), default=1, show_default=True, help="Replies per request.")
@click.option(
    "--parameter",
    "-p",
    multiple=True,
    metavar="NAME=VALUE",
    help="Request parameter, such as max_tokens=64. Repeatable.",
)
@click.option(
    "--image-detail", type=click.Choice(["low", "high", "auto", "original"]), help="OpenAI's detail of pictures."
)
@click.option("--image-format", default="png", show_default=True, metavar="FORMAT", help="png, jpeg:90 or webp:90.")
@click.option("--image-size", type=click.IntRange(16, 8192), metavar="N", help="Longest side of pictures, in pixels.")
@click.option("--task", multiple=True, metavar="NAME", help="Only this task.")
@click.option("--engine", multiple=True, metavar="NAME", help="Only rows of this engine.")
@click.option("--split", type=click.Choice(["train", "validation", "test"]), help="Only this split; groups stay whole.")
@split_options
@limit_option
@click.option("--max-requests", type=click.IntRange(0), metavar="N", help="Maximum number of requests in this call.")
@click.option("--max-cost", type=click.FloatRange(0), metavar="COST", help="Maximum total cost of the results.")
@click.option("--price", type=(float, float), metavar="IN OUT", help="Price per million input and output tokens.")
@click.option("--rate", type=click.FloatRange(0, min_open=True), metavar="N", help="Maximum requests per minute.")
@click.option("--concurrency", type=click.IntRange(1, 256), default=8, show_default=True, help="Concurrent requests.")
@click.option(
    "--retries", type=click.IntRange(0), default=5, show_default=True, help="Retries per request, with backoff."
)
@click.option(
    "--timeout",
    type=click.FloatRange(0, min_open=True),
    default=120,
    show_default=True,
    help="Time limit per try, in seconds.",
)
@click.option(
    "--begins",
    type=click.Choice(["context", "first", "after"]),
    help="What clips begin with: the context, its last picture, or what comes after.  [default: found in each clip]",
)
@click.option("--masks", default="", metavar="sam2:FOLDER", help="Find objects in clips by this model, not by colour.")
@click.option("--cache", type=_PATH, metavar="FILE", help="File in which replies are cached.")
@click.option("--dry-run", is_flag=True, help="Print the plan and the first request; send nothing.")
@click.option("--rescore", type=_PATH, metavar="FILE", help="Score stored replies again; send nothing.")
@seed_option
@json_option
def evaluate_command(dataset: Path | None, rescore: Path | None, as_json: bool, **options: Any) -> None:
    """Ask a model the questions of a dataset, and store and score its replies.

    An interrupted run resumes with the same command. The key of a server is read from OPENAI_API_KEY and written
    nowhere. Exits with 1 if no reply could be read or requests failed; it prints the first cause, and the same command
    retries them.
    """
    if rescore is not None:
        _rescore(rescore, as_json)
        return
    if dataset is None or options["model"] is None:
        raise WmsError("missing DATASET or --model: `wmspec evaluate DATASET --model MODEL -o results.parquet`")
    if options["model"].startswith(CLIPS):
        _evaluate_clips(dataset, options, as_json)
        return
    for name in ("begins", "masks"):
        if options[name]:
            raise WmsError(f"--{name}: only for -m clips:FOLDER")
    if options["model"].startswith(SURPRISES):
        _evaluate_surprises(dataset, options, as_json)
        return
    run, server = _run(dataset, options)
    if options["dry_run"]:
        _print_requests(run)
        return
    _evaluate(run, server, options, as_json)


def _evaluate_surprises(dataset: Path, options: dict[str, Any], as_json: bool) -> None:
    from wmspec.eval.clips.surprise import SurpriseRun, evaluate_surprises

    output, opened, selection = _of_films(dataset, options)
    run = SurpriseRun(opened, options["model"], selection)
    with progress_bar(len(run.questions), "evaluating", "questions") as bar:
        ended = evaluate_surprises(run, output, lambda right, count: bar(_so_far(right, count, 0.0), 1))
    _print_counts(ended.counts, output, as_json)


def _results_file(options: dict[str, Any]) -> Path:
    """Return the results file. Raises WmsError if it is missing."""
    output: Path | None = options["output"]
    if output is None or output.suffix != ".parquet":
        raise WmsError("missing output: add -o results.parquet")
    return output


def _of_films(dataset: Path, options: dict[str, Any]) -> tuple[Path, DatasetReader, Selection]:
    """Return results file, dataset and selection. Raises WmsError for an option that models of films do not have."""
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.models.question import Selection

    output = _results_file(options)
    for name in ("ablate", "permute", "dry_run"):
        if options[name]:
            raise WmsError(f"--{name.replace('_', '-')}: not for models of films")
    selection = Selection(options["task"], options["engine"], options["limit"])
    return output, DatasetReader.open(dataset).intact(), selection


def _evaluate_clips(dataset: Path, options: dict[str, Any], as_json: bool) -> None:
    from wmspec.eval.clips.questions import selected
    from wmspec.eval.clips.run import ClipRun, evaluate_clips

    output, opened, selection = _of_films(dataset, options)
    model, masks = options["model"].removeprefix(CLIPS), options["masks"]
    run = ClipRun(opened, model, selection, options["begins"], masks=masks)
    with progress_bar(len(selected(opened, selection)), "scoring", "clips") as bar:
        ended = evaluate_clips(run, output, lambda right, count: bar(_so_far(right, count, 0.0), 1))
    _print_counts(ended.counts, output, as_json)
    if ended.unknown and not as_json:
        click.echo(f"{len(ended.unknown):,} files belong to no question, such as {ended.unknown[0]}", err=True)
    status = ended.counts.status
    read, failed = ended.counts.replies - status.get("error", 0), status.get("error", 0)
    exit_if_failed(
        Tally("clip could be read", read, "clips", ended.counts.replies, failed, ended.error, how="failed", most=0)
    )


def _run(dataset: Path, options: dict[str, Any]) -> tuple[Run, Server | None]:
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.models import baselines, prompt, server
    from wmspec.eval.models.images import ImageOptions
    from wmspec.eval.models.limits import Limits
    from wmspec.eval.models.question import Selection
    from wmspec.eval.models.run import Run, Settings
    from wmspec.eval.models.splits import Splits

    opened = DatasetReader.open(dataset).intact()
    if options["ablate"] and options["model"] in baselines.NAMES:
        raise WmsError(f"--ablate: `{options['model']}` has no request to ablate; choose a model")
    template = options["prompt"] or ("frames" if opened.film is not None else "default")
    served = options["model"].startswith("openai:")
    if options["structured"] and not served:
        raise WmsError("--structured: only for -m openai:NAME")
    url = server.address(options["base_url"]) if served else None
    images = ImageOptions.parse(options["image_format"], options["image_size"], options["image_detail"])
    settings = Settings(
        model=options["model"],
        prompt_name=Path(template).stem,
        prompt=prompt.load(template),
        address=url,
        ablation=options["ablate"],
        seed=options["seed"],
        parameters=_parameters(options["parameter"], options["samples"])
        if served or options["model"].startswith("hf:")
        else (),
        images=images.record,
        structured=options["structured"],
    )
    limits = Limits(options["max_requests"], options["rate"], options["max_cost"])
    selection = Selection(
        options["task"],
        options["engine"],
        options["limit"],
        options["split"] or "",
        Splits.parse(options["shares"], options["holdouts"]),
    )
    if note := selection.repetition(opened):
        tell(note)
    run = Run(opened, settings, selection, options["permute"], options["samples"], limits)
    if url is None:
        return run, None
    connection = server.Server(
        url, options["timeout"], options["retries"], options["price"], images, options["structured"]
    )
    return run, connection


def _parameters(written: tuple[str, ...], samples: int) -> tuple[tuple[str, Any], ...]:
    """Return the request parameters, sorted by name. `NAME=null` removes a default."""
    values: dict[str, Any] = dict(_DEFAULTS)
    for each in written:
        name, equals, value = each.partition("=")
        if not name or not equals:
            raise WmsError(f"--parameter {each}: expected NAME=VALUE, such as max_tokens=64")
        try:
            values[name] = json.loads(value)
        except ValueError:
            values[name] = value
    if samples > 1 and values["temperature"] == 0 and not any(name.startswith("reasoning") for name in values):
        raise WmsError("--samples: all replies are equal at temperature 0; add --parameter temperature=0.7")
    return tuple(sorted((name, value) for name, value in values.items() if value is not None))


def _evaluate(run: Run, server: Server | None, options: dict[str, Any], as_json: bool) -> None:
    from wmspec.eval.models.cache import CachedModel
    from wmspec.eval.models.images import ImageOptions
    from wmspec.eval.models.model import Model
    from wmspec.eval.models.models import open_model
    from wmspec.eval.models.run import evaluate

    output = _results_file(options)
    settings = run.settings
    parameters = dict(settings.parameters)
    chosen = {written.partition("=")[0] for written in options["parameter"]}
    images = ImageOptions.parse(options["image_format"], options["image_size"], options["image_detail"])
    model: Model = open_model(
        settings.model, run.dataset, settings.seed, parameters, server, options["concurrency"],
        frozenset(_DEFAULTS) - chosen, images,
    )  # fmt: skip
    if options["cache"] is not None:
        model = CachedModel(model, parameters, options["cache"])
    total = sum(len(list(run.asks(question))) for question in run.chosen())
    with progress_bar(total, "asking", "replies") as bar:
        ended = evaluate(run, model, output, lambda right, count, cost: bar(_so_far(right, count, cost), 1))
    _print_counts(ended.counts, output, as_json)
    for sentence in () if as_json else (*ended.causes, *ended.notes):
        click.echo(str(sentence))
    if ended.missing and not as_json:
        click.echo(f"{ended.missing:,} requests were not sent because of a limit; the same command resumes")
    exit_if_failed(_tally(ended))


def _tally(ended: RunResult) -> Tally:
    """Return the counts of a run: every failed request counts, since the same command retries it."""
    status = ended.counts.status
    failed = status.get("error", 0)
    first = next((cause.example or cause.cause for cause in ended.causes if cause.outcome == "error"), "")
    read, total = status.get("answered", 0), ended.counts.replies
    return Tally("reply could be read", read, "requests", total, failed, first, how="failed", most=0)


def _so_far(right: int, count: int, cost: float) -> str:
    return f"{right / count:.1%} right" + (f", cost {cost:.4g}" if cost else "")


def _print_counts(counted: Counts, path: Path, as_json: bool) -> None:
    """Print the scores for a terminal or as JSON."""
    if as_json:
        from dataclasses import asdict

        click.echo(json.dumps(asdict(counted), indent=1))
        return
    chance = f"; guessing: {counted.chance:.1%}" if counted.chance is not None else ""
    share = counted.right / counted.replies if counted.replies else 0.0
    click.echo(f"{path}: {counted.replies:,} replies, {counted.right:,} right ({share:.1%}{chance})")
    read = counted.status.get("answered", 0)
    lost = {name: count for name, count in counted.status.items() if name != "answered"}
    if lost:
        counts = ", ".join(f"{count:,} {name}" for name, count in lost.items())
        among = f"; of the {read:,} answered {counted.right / read:.1%} are right" if read else ""
        click.echo(f"counted as wrong: {counts}{among}")
    if counted.tokens_in or counted.tokens_out:
        cost = f"; cost {counted.cost:.4g}" if counted.cost is not None else ""
        click.echo(f"{counted.tokens_in:,} tokens sent, {counted.tokens_out:,} received{cost}")


def _rescore(path: Path, as_json: bool) -> None:
    from wmspec.eval.clips.run import rescore_clips
    from wmspec.eval.models.results import rescore

    counted, changed = rescore_clips(path) or rescore(path)
    _print_counts(counted, path, as_json)
    if not as_json:
        click.echo(f"{changed:,} scores have changed")


def _print_requests(run: Run) -> None:
    """Print the number of requests and the first one, with sizes in place of pictures."""
    chosen = run.chosen()
    click.echo(f"{sum(len(list(run.asks(question))) for question in chosen):,} requests for {len(chosen):,} questions")
    first: Ask | None = run.first()
    if first is not None:
        from wmspec.eval.models.request import Text

        click.echo(f"the first, {first.question.id}, prompt {run.settings.prompt.hash}:\n\n{first.request.system}\n")
        for part in first.request.parts:
            name = type(part).__name__.lower()
            click.echo(part.text if isinstance(part, Text) else f"<{name}, {len(part.content):,} bytes>")
