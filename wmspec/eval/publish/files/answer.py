"""Answer the questions of this folder: `python answer.py --model NAME` writes `submission.jsonl`, and resumes it."""

from __future__ import annotations

import argparse
import base64
import json
from pathlib import Path
from typing import Any

import openai
import pyarrow.parquet as pq
from wmspec_reply import is_withheld

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
    except openai.APIStatusError as error:
        withheld = is_withheld(error.status_code, str(error))
        if not (withheld or isinstance(error, openai.BadRequestError)):
            raise
        return {"id": row["id"], "finish_reason": "content_filter" if withheld else None, "error": str(error)[:2000]}
    refusal = getattr(chosen.message, "refusal", None)
    finish = "refusal" if refusal else chosen.finish_reason
    return {"id": row["id"], "reply": text(chosen.message.content), "finish_reason": finish}


def text(content: Any) -> str:
    """Return the text of a message's content, a string or a list of parts."""
    parts = content if isinstance(content, list) else [{"text": content}]
    return "\n".join(part["text"] for part in parts if isinstance(part.get("text"), str))


def main() -> None:
    """Answer all questions without a line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", required=True, help="model of the server")
    parser.add_argument("--base-url", help="server; OpenAI by default")
    parser.add_argument("--name", help="name of the model in the submission")
    parser.add_argument("--output", type=Path, default=FOLDER / "submission.jsonl")
    chosen = parser.parse_args()
    index = json.loads((FOLDER / "questions.json").read_text())
    written = chosen.output.read_text() if chosen.output.exists() else ""
    whole = written[: written.rfind("\n") + 1]  # a stop may have cut the last line off
    if whole != written:
        chosen.output.write_text(whole)
    if not whole:
        about = {"questions": index["digest"], "model": chosen.name or chosen.model, "prompt": index["prompt"]}
        chosen.output.write_text(json.dumps(about) + "\n")
    known = {json.loads(line).get("id") for line in whole.splitlines()}
    client = openai.OpenAI(base_url=chosen.base_url)
    with chosen.output.open("a") as file:
        for task in index["tasks"]:
            for row in pq.read_table(FOLDER / f"data/{task}.parquet").to_pylist():
                if row["id"] not in known:
                    file.write(json.dumps(reply(client, chosen.model, row)) + "\n")
                    file.flush()


if __name__ == "__main__":
    main()
