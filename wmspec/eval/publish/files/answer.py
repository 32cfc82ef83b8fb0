"""Answer the questions of this folder: `python answer.py --model NAME` writes `submission.jsonl`, and resumes it."""

from __future__ import annotations

import argparse
import base64
import json
import sys
from pathlib import Path
from typing import Any

import openai
import pyarrow.parquet as pq
from wmspec_reply import is_withheld

FOLDER = Path(__file__).parent
#: Errors after which no request can succeed, and the number of failed requests in a row that ends the run.
HOPELESS = (openai.AuthenticationError, openai.PermissionDeniedError, openai.NotFoundError)
MAX_ERRORS = 20


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
    """Return the line of a question. Raises an error of the client if no request can succeed."""

    def safe(words: str, length: int | None = None) -> str:
        """Return words without the key, which a server may echo; short ones, such as `none`, are no secrets."""
        return (words.replace(client.api_key, "[key]") if len(client.api_key) >= 8 else words)[:length]

    try:
        chosen = client.chat.completions.create(model=model, messages=messages(row)).choices[0]
        refusal = getattr(chosen.message, "refusal", None)
        finish = "refusal" if refusal else safe(str(chosen.finish_reason or "stop"), 40)
        return {"id": row["id"], "reply": safe(text(chosen.message.content)), "finish_reason": finish}
    except (openai.OpenAIError, ValueError, LookupError, TypeError, AttributeError) as error:
        withheld = is_withheld(getattr(error, "status_code", None), str(error))
        if not withheld and isinstance(error, HOPELESS):
            raise
        message = safe(f"{type(error).__name__}: {error}", 2000)
        return {"id": row["id"], "finish_reason": "content_filter" if withheld else None, "error": message}


def failed(line: dict[str, Any]) -> bool:
    """Whether a line holds no reply, so that the question is sent again."""
    return bool(line.get("error")) and not line.get("finish_reason")


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
    lines = resumed(chosen.output)
    about = {"questions": index["digest"], "model": chosen.name or chosen.model, "prompt": index["prompt"]}
    lines = lines or [json.dumps(about) + "\n"]
    known = {json.loads(line).get("id") for line in lines}
    part = chosen.output.with_name(chosen.output.name + ".part")
    part.write_text("".join(lines))
    part.replace(chosen.output)
    client, errors, in_a_row = openai.OpenAI(base_url=chosen.base_url), 0, 0
    with chosen.output.open("a") as file:
        for task in index["tasks"]:
            for row in pq.read_table(FOLDER / f"data/{task}.parquet").to_pylist():
                if row["id"] not in known:
                    line = reply(client, chosen.model, row)
                    file.write(json.dumps(line) + "\n")
                    file.flush()
                    errors, in_a_row = errors + failed(line), in_a_row + 1 if failed(line) else 0
                    if in_a_row == MAX_ERRORS:
                        sys.exit(f"{MAX_ERRORS} requests in a row have failed; the last: {line['error']}")
    if errors:
        sys.exit(f"{errors} requests have failed; the same command sends them again")


def resumed(path: Path) -> list[str]:
    """Return the lines of an earlier run, without a last one that a stop cut off, and without failed requests."""
    written = path.read_text() if path.exists() else ""
    lines = written[: written.rfind("\n") + 1].splitlines(keepends=True)
    return [line for line in lines if not failed(json.loads(line))]


if __name__ == "__main__":
    main()
