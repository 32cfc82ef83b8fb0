"""Answer the questions of this folder: `python answer.py --model NAME` writes `submission.jsonl`, and resumes it."""

from __future__ import annotations

import argparse
import base64
import json
from pathlib import Path
from typing import Any

import openai
import pyarrow.parquet as pq

FOLDER = Path(__file__).parent


def messages(row: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the messages of a question."""
    urls = [f"data:image/png;base64,{base64.b64encode(image['bytes']).decode()}" for image in row["images"]]
    turn = [
        {"type": "text", "text": part["text"]}
        if part["image"] is None
        else {"type": "image_url", "image_url": {"url": urls[part["image"]]}}
        for part in row["content"]
    ]
    system = [{"role": "system", "content": row["system"]}] if row["system"] else []
    return [*system, {"role": "user", "content": turn}]


def reply(client: Any, model: str, row: dict[str, Any]) -> dict[str, Any]:
    """Return the line of a question."""
    try:
        chosen = client.chat.completions.create(model=model, messages=messages(row)).choices[0]
    except openai.BadRequestError as error:
        finish = "content_filter" if "content_filter" in str(error) else None
        return {"id": row["id"], "finish_reason": finish, "error": str(error)[:2000]}
    refusal = getattr(chosen.message, "refusal", None)
    finish = "refusal" if refusal else chosen.finish_reason
    return {"id": row["id"], "reply": chosen.message.content or "", "finish_reason": finish}


def main() -> None:
    """Answer all questions without a line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", required=True, help="model of the server")
    parser.add_argument("--base-url", help="server; OpenAI by default")
    parser.add_argument("--name", help="name of the model in the submission")
    parser.add_argument("--output", type=Path, default=FOLDER / "submission.jsonl")
    chosen = parser.parse_args()
    index = json.loads((FOLDER / "questions.json").read_text())
    if not chosen.output.exists():
        about = {"questions": index["digest"], "model": chosen.name or chosen.model, "prompt": index["prompt"]}
        chosen.output.write_text(json.dumps(about) + "\n")
    known = {json.loads(line).get("id") for line in chosen.output.read_text().splitlines()}
    client = openai.OpenAI(base_url=chosen.base_url)
    with chosen.output.open("a") as file:
        for task in index["tasks"]:
            for row in pq.read_table(FOLDER / f"data/{task}.parquet").to_pylist():
                if row["id"] not in known:
                    file.write(json.dumps(reply(client, chosen.model, row)) + "\n")
                    file.flush()


if __name__ == "__main__":
    main()
