"""Questions about a physical world, for VLMEvalKit: `python wmspec_run.py CHECKOUT --model MODEL`, with its options.

CHECKOUT is VLMEvalKit. This script adds the questions of this folder to its datasets and runs its `run.py`. Words and
pictures keep their order, and replies are parsed as in wmspec.
"""

from __future__ import annotations

import base64
import json
import runpy
import sys
from pathlib import Path
from typing import Any

from wmspec_reply import mark

_FOLDER = Path(__file__).resolve().parent
#: What VLMEvalKit writes in place of a reply after a failed request.
_FAILED = "Failed to obtain answer via API"


def _dataset() -> Any:
    """Return the dataset class of the questions."""
    import pandas as pd
    import vlmeval.dataset as known
    from vlmeval.dataset.image_base import ImageBaseDataset
    from vlmeval.smp import dump, load

    (table,) = _FOLDER.glob("Wmspec_*.tsv")

    class WmspecDataset(ImageBaseDataset):
        TYPE = "VQA"

        @classmethod
        def supported_datasets(cls) -> list[str]:
            return [table.stem]

        def load_data(self, dataset: str) -> Any:
            return load(str(_FOLDER / f"{dataset}.tsv"))

        def build_prompt(self, line: Any) -> list[dict[str, str]]:
            line = self.data.iloc[line] if isinstance(line, int) else line
            images = line["image"] if isinstance(line["image"], list) else [line["image"]]
            fields = json.loads(line["wmspec"])
            message = [{"type": "text", "value": fields["system"], "role": "system"}] if fields["system"] else []
            for part in fields["content"]:
                if part["image"] is None:
                    message.append({"type": "text", "value": part["text"]})
                else:
                    path = Path(self.img_root) / f"{line['index']}_{part['image']}.png"
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.write_bytes(base64.b64decode(images[part["image"]]))
                    message.append({"type": "image", "value": str(path)})
            return message

        @classmethod
        def evaluate(cls, eval_file: str, **options: Any) -> Any:  # noqa: ARG003  VLMEvalKit passes more
            replies = load(eval_file)
            rows = []
            for _, line in replies.iterrows():
                fields = json.loads(line["wmspec"])["truth"]
                said = str(line["prediction"])
                marked = mark(said, fields.pop("options"), fields.pop("labels"), **fields)
                outcome = "error" if _FAILED in said else marked.outcome
                rows.append(
                    {"category": line["category"], "right": outcome == "answered" and marked.right, "outcome": outcome}
                )
            scored = pd.DataFrame(rows)
            by_task = scored.groupby("category")["right"].mean()
            shares = scored["outcome"].value_counts(normalize=True)
            score = {"Overall": scored["right"].mean(), **shares.to_dict(), **by_task.to_dict()}
            table = pd.DataFrame([score])
            dump(table, eval_file.rsplit(".", 1)[0] + "_acc.csv")
            return table

    known.DATASET_CLASSES.append(WmspecDataset)
    known.SUPPORTED_DATASETS.extend(WmspecDataset.supported_datasets())
    return WmspecDataset


def main() -> None:
    """Run VLMEvalKit on the questions."""
    checkout = Path(sys.argv[1]).resolve()
    sys.path.insert(0, str(checkout))
    (name,) = _dataset().supported_datasets()
    sys.argv = [str(checkout / "run.py"), "--data", name, *sys.argv[2:]]
    runpy.run_path(sys.argv[0], run_name="__main__")


if __name__ == "__main__":
    main()
