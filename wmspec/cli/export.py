"""`wmspec export`: write a dataset for other evaluation tools."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wmspec.cli.common import exit_if_failed, limit_option, split_options, tell
from wmspec.core.diagnostics import WmsError
from wmspec.core.tally import Tally

if TYPE_CHECKING:
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.models.question import Selection

_PATH = click.Path(path_type=Path)
TOOLS = ("inspect", "lmms-eval", "vlmevalkit", "hf", "chat", "questions", "video", "physics-iq")


@click.command("export")
@click.argument("dataset", type=_PATH)
@click.option("--to", "tool", required=True, type=click.Choice(TOOLS))
@click.option("--output", "-o", type=_PATH, required=True, metavar="FOLDER", help="Output folder.")
@click.option(
    "--prompt", default="default", show_default=True, help="default, frames, montage, numbers, paper, or a file."
)
@click.option("--secret", type=_PATH, metavar="FILE", help="For questions: secret that hides ids and signs receipts.")
@split_options
@click.option("--task", multiple=True, metavar="NAME", help="Only this task.")
@click.option("--engine", multiple=True, metavar="NAME", help="Only rows of this engine.")
@limit_option
@click.option("--frames", is_flag=True, help="For video: also write a PNG file of each shown frame.")
def export_command(
    dataset: Path,
    tool: str,
    output: Path,
    prompt: str,
    secret: Path | None,
    shares: str,
    holdouts: tuple[str, ...],
    task: tuple[str, ...],
    engine: tuple[str, ...],
    limit: int | None,
    frames: bool,
) -> None:
    """Export a dataset for Inspect, lmms-eval, VLMEvalKit or Hugging Face `datasets`, or its questions without answers.

    `chat` is training data in splits by control groups (--shares, --holdout), with answers. `questions` replaces
    a private dataset in public: without answers, with ids hidden by --secret (a file, created if missing).
    `wmspec submit`, `score` and `leaderboard` do the rest. `video` has the inputs of video models: prompts and the
    shown films, without answers. `physics-iq` has the films in the layout of that benchmark, with the answers.

    Other folders have requests equal to those of `wmspec evaluate`, the parser of replies, and a README.

    Exits with 1 if no question was written.
    """
    from wmspec.dataset.build.reader import DatasetReader
    from wmspec.eval.export.export import Export, export
    from wmspec.eval.models import prompt as prompts
    from wmspec.eval.models.question import Selection
    from wmspec.eval.models.splits import Splits

    opened = DatasetReader.open(dataset).intact()
    selection = Selection(task, engine, limit)
    if tool == "video":
        from wmspec.eval.export.video import export_video

        count = export_video(opened, selection, prompt, output, every_frame=frames)
        click.echo(f"{output}: {count:,} questions for video models; {output / 'README.md'} says what to do")
        exit_if_failed(Tally("question was written", count))
        return
    if tool == "physics-iq":
        from wmspec.eval.export.physics_iq import export_physics_iq

        count = export_physics_iq(opened, selection, prompt, output)
        click.echo(f"{output}: {count:,} questions in the layout of Physics-IQ; {output / 'README.md'} says what to do")
        exit_if_failed(Tally("question was written", count))
        return
    if frames:
        raise WmsError("--frames: only for --to video")
    if note := selection.repetition(opened):
        tell(note)
    if (secret is None) == (tool == "questions"):
        raise WmsError("--secret FILE belongs to --to questions, which needs it")
    if secret is not None:
        _publish(opened, selection, prompt, secret, output)
        return
    splits = Splits.parse(shares, holdouts)
    what = Export(opened, selection, Path(prompt).stem, prompts.load(prompt), splits)
    count = export(what, tool, output)
    click.echo(f"{output}: {count:,} questions for {tool}; {output / 'README.md'} says how to run it")
    exit_if_failed(Tally("question was written", count))


def _publish(dataset: DatasetReader, selection: Selection, prompt: str, secret: Path, output: Path) -> None:
    from wmspec.dataset.attestation import LONG_SEED, has_guessable_seed
    from wmspec.eval.models import prompt as prompts
    from wmspec.eval.publish.questions import publish
    from wmspec.eval.publish.secret import Secret

    if has_guessable_seed(dataset):
        tell(
            f"warning: the seed {dataset.manifest['seed']} can be found by trying, and with it the answers, if the "
            f"specs are public; make the dataset with a long one: {LONG_SEED}"
        )
    count = publish(dataset, selection, Path(prompt).stem, prompts.load(prompt), Secret.open_or_create(secret), output)
    click.echo(f"{output}: {count:,} questions without answers; publish it, and keep {secret} and the dataset")
    exit_if_failed(Tally("question was written", count))
