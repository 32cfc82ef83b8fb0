"""Train a model on the chats of this folder, with TRL: `python train.py MODEL OUTPUT`.

MODEL is a vision-language model that transformers opens, OUTPUT the folder of the trained one. Answers are imitated, or
with `--method grpo` replies are rewarded by `reward.py`. `--set NAME=VALUE` sets an option of TRL's SFTConfig or
GRPOConfig, such as `--set num_train_epochs=3 --set learning_rate=1e-5`.
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any

from datasets import Image, List, load_dataset
from reward import reward
from transformers import AutoModelForImageTextToText, AutoProcessor
from trl import GRPOConfig, GRPOTrainer, SFTConfig, SFTTrainer

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


def _trainer(method: str, model: str, output: Path, options: dict[str, Any]) -> Any:
    names = [name for name in ("train", "validation") if Path(f"{name}.jsonl").exists()]
    chats = load_dataset("json", data_files={name: f"{name}.jsonl" for name in names})
    chats = chats.select_columns(["messages", "images", "truth"]).cast_column("images", List(Image()))
    validation = chats.get("validation")
    common = {
        "model": AutoModelForImageTextToText.from_pretrained(model),
        "processing_class": AutoProcessor.from_pretrained(model),
    }
    defaults = {"eval_strategy": "epoch" if validation else "no", "report_to": "none"}
    if method == "sft":
        # Pictures are many tokens: a limit of length would cut the answer off.
        settings = SFTConfig(str(output), **{"max_length": None, **defaults, **options})
        return SFTTrainer(args=settings, train_dataset=chats["train"], eval_dataset=validation, **common)
    prompts = chats.map(lambda row: {"prompt": row["messages"][:-1]}, remove_columns="messages")
    return GRPOTrainer(
        args=GRPOConfig(str(output), **defaults | options),
        reward_funcs=reward,
        train_dataset=prompts["train"],
        eval_dataset=prompts.get("validation"),
        **common,
    )


def main() -> None:
    """Train the model on `train.jsonl`, and evaluate it on `validation.jsonl` if there is one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model")
    parser.add_argument("output", type=Path)
    parser.add_argument("--method", choices=["sft", "grpo"], default="sft")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", dest="options")
    chosen = parser.parse_args()
    model = str(Path(chosen.model).resolve()) if Path(chosen.model).exists() else chosen.model
    output = chosen.output.resolve()
    os.chdir(_FOLDER)  # paths of pictures are relative to this folder
    trainer = _trainer(chosen.method, model, output, _options(chosen.options))
    trainer.train()
    trainer.save_model(str(output))


if __name__ == "__main__":
    main()
