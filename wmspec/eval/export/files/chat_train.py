"""Fine-tune a model on the chats of this folder: `python train.py MODEL OUTPUT`, with TRL.

MODEL is a vision-language model that transformers opens, OUTPUT the folder of the tuned one. `--set NAME=VALUE` sets an
option of TRL's SFTConfig, such as `--set num_train_epochs=3 --set learning_rate=1e-5`.
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any

from datasets import Image, List, load_dataset
from transformers import AutoModelForImageTextToText, AutoProcessor
from trl import SFTConfig, SFTTrainer

_FOLDER = Path(__file__).resolve().parent


def _options(written: list[str]) -> dict[str, Any]:
    options: dict[str, Any] = {}
    for each in written:
        name, _, value = each.partition("=")
        try:
            options[name] = json.loads(value)
        except ValueError:
            options[name] = value
    return options


def main() -> None:
    """Tune the model on `train.jsonl`, and evaluate its loss on `validation.jsonl` if there is one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model")
    parser.add_argument("output", type=Path)
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", dest="options")
    chosen = parser.parse_args()
    model, output = chosen.model, chosen.output.resolve()
    if Path(model).exists():
        model = str(Path(model).resolve())
    os.chdir(_FOLDER)  # paths of pictures are relative to this folder
    names = [name for name in ("train", "validation") if Path(f"{name}.jsonl").exists()]
    chats = load_dataset("json", data_files={name: f"{name}.jsonl" for name in names})
    chats = chats.select_columns(["messages", "images"]).cast_column("images", List(Image()))
    validation = chats.get("validation")
    # Pictures are many tokens: a limit of length would cut the answer off.
    options = {"max_length": None, "eval_strategy": "epoch" if validation else "no", "report_to": "none"}
    trainer = SFTTrainer(
        model=AutoModelForImageTextToText.from_pretrained(model),
        processing_class=AutoProcessor.from_pretrained(model),
        args=SFTConfig(str(output), **(options | _options(chosen.options))),
        train_dataset=chats["train"],
        eval_dataset=validation,
    )
    trainer.train()
    trainer.save_model(str(output))


if __name__ == "__main__":
    main()
