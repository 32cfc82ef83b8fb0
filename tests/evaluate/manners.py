"""Manners of replying, each with its outcome and cause, and a server that has them."""

from __future__ import annotations

import json
import re
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from tests.evaluate.loopback import serving

#: What a response is made of: status, body. A body of bytes is sent as it is; a status of 0 drops the connection.
Response = tuple[int, dict[str, Any] | bytes]


@dataclass(frozen=True)
class Manner:
    """A manner: the response to the request with a body at a try (from 1), for a model that takes the label.

    `in_inspect` is the provider of Inspect that reads it, with options.
    """

    respond: Callable[[str, dict[str, Any], int], Response]
    outcome: str = "answered"
    cause: str = ""
    note: str = ""
    in_inspect: tuple[str, ...] = ("openai-api/loopback",)


def chat(content: Any, finish: str = "stop", **message: Any) -> Response:
    """A chat completion."""
    said = {"role": "assistant", "content": content, **message}
    usage: dict[str, Any] = {"prompt_tokens": 100, "completion_tokens": 20, "total_tokens": 120}
    usage |= {"completion_tokens_details": {"reasoning_tokens": 7}}
    choices = [{"index": 0, "finish_reason": finish, "message": said}]
    return 200, {
        "id": "c", "object": "chat.completion", "created": 1, "model": "manners-1", "choices": choices, "usage": usage,
    }  # fmt: skip


def text(template: str, **more: Any) -> Manner:
    """A manner that replies with a text, in which {x} is the label and {y} another one."""

    def respond(label: str, body: dict[str, Any], tries: int) -> Response:
        other = "B" if label == "A" else "A"
        return chat(template.replace("{x}", label).replace("{y}", other))

    return Manner(respond, **more)


def always(response: Response, **more: Any) -> Manner:
    return Manner(lambda label, body, tries: response, **more)


def error(status: int, message: str, code: str | None = None) -> Response:
    return status, {"error": {"message": message, "type": "invalid_request_error", "code": code}}


def at_last(*failures: Response) -> Manner:
    """A manner that answers rightly after these failures."""
    return Manner(lambda label, body, tries: failures[tries - 1] if tries <= len(failures) else chat(label))


def _rejects_old_names(label: str, body: dict[str, Any], tries: int) -> Response:
    if "max_tokens" in body:
        said = (
            "Unsupported parameter: 'max_tokens' is not supported with this model. Use 'max_completion_tokens' instead."
        )
        return error(400, said, "unsupported_parameter")
    if "temperature" in body:
        said = "Unsupported value: 'temperature' does not support 0 with this model. Only the default (1) value is."
        return error(400, said, "unsupported_value")
    return chat(label)


def _slow(label: str, body: dict[str, Any], tries: int) -> Response:
    time.sleep(3)
    return chat(label)


UNREAD = "no option or number can be read"
EMPTY = "the reply is empty"
CUT = "cut off by the limit of tokens"
FILTERED = "withheld by a filter (content_filter)"

MISTRAL = ("mistral", "-M", "conversation_api=false")
NO_DEFAULTS = ("openai-api/loopback", "-T", "defaults=false")

MANNERS: dict[str, Manner] = {
    # right, in several forms
    "right": text("{x}"),
    "lower": text("{x}."),
    "chatty": text("Let me look at the pictures. The answer is ({x}) because it moves, not {y}."),
    "enumerating": text("({y}) shows it too early. ({x}) shows it as expected. Therefore, ({x})."),
    "eliminating": text("{y} is wrong. So {x}."),
    "boxed": text("The motion goes on.\n\n$\\boxed{\\text{{x}}}$"),
    "tagged": text("<reasoning>{y}?</reasoning><answer>{x}</answer>"),
    "json": text('```json\n{"reason": "not {y}", "answer": "{x}"}\n```'),
    "think": text("<think>The answer is {y}.</think>\n\n{x}"),
    "thought": text("<thought>The answer is {y}</thought>{x}"),
    "unopened": text("The answer is {y}? No.\n</think>\n{x}"),
    "kimi": text("◁think▷The answer is {y}.◁/think▷{x}"),
    "harmony": text("<|channel|>analysis<|message|>{y} fits.<|end|><|start|>assistant<|channel|>final<|message|>{x}"),
    "reasoning field": Manner(lambda label, *_: chat(label, reasoning_content="The answer is A. No, B. No, A.")),
    "parts": Manner(
        lambda label, *_: chat([{"type": "text", "text": "The answer:"}, {"type": "text", "text": label}]),
        in_inspect=MISTRAL,
    ),
    "thinking parts": Manner(
        lambda label, *_: chat([
            {"type": "thinking", "thinking": [{"type": "text", "text": "A or B"}]},
            {"type": "text", "text": label},
        ]),
        in_inspect=MISTRAL,
    ),
    "Chinese": text("球继续滚动，{y}不对，因此答案是{x}。"),
    "Japanese": text("{y}は間違いです。したがって、答えは{x}です。"),
    "German": text("{y} ist falsch. Also ist die richtige Antwort {x}."),
    "French": text("{y} est faux. La bonne réponse est donc {x}."),
    "Spanish": text("{y} es incorrecta. Por lo tanto, la respuesta es {x}."),
    "one token": Manner(lambda label, *_: chat(label, "length")),
    # after failures
    "busy at first": at_last(error(429, "slow down"), error(429, "slow down")),
    "broken at first": at_last(error(500, "broken")),
    "dropped at first": at_last((0, b"")),
    "new names": Manner(_rejects_old_names, note="max_completion_tokens=16384", in_inspect=NO_DEFAULTS),
    # without an answer
    "two labels": text("{x}, {y}", outcome="unparsed", cause=UNREAD),
    "either": text("It could be {x} or {y}.", outcome="unparsed", cause=UNREAD),
    "descriptions": text("({x}) shows the start. ({y}) shows the end.", outcome="unparsed", cause=UNREAD),
    "supposed": text("If it were heavier, the answer would be {x}.", outcome="unparsed", cause=UNREAD),
    "denied": text("It is not {y}.", outcome="unparsed", cause=UNREAD),
    "apology": text("I'm sorry, I can't see any pictures.", outcome="unparsed", cause=UNREAD),
    "empty": text("", outcome="unparsed", cause=EMPTY),
    "no content": always(chat(None), outcome="unparsed", cause=EMPTY),
    "only reasoning": Manner(
        lambda label, *_: chat("", reasoning_content=f"The answer is {label}."), outcome="unparsed", cause=EMPTY
    ),
    "cut": Manner(
        lambda label, *_: chat(f"Let me look. The answer is {label}, but", "length"), outcome="truncated", cause=CUT
    ),
    "cut in thought": Manner(lambda label, *_: chat(f"<think>It is {label}", "length"), outcome="truncated", cause=CUT),
    "cut in reasoning": Manner(
        lambda label, *_: chat("", "length", reasoning_content=f"It is {label}"), outcome="truncated", cause=CUT
    ),
    "filtered": Manner(lambda label, *_: chat(label, "content_filter"), outcome="refused", cause=FILTERED),
    "refusal field": always(
        chat(None, refusal="I can't help with that."), outcome="refused", cause="withheld by a filter (refusal)",
    ),
    "filter status": always(
        error(400, "The response was filtered due to the content management policy.", "content_filter"),
        outcome="refused", cause=FILTERED,
    ),
    "moderation": always(
        error(403, "Your input was flagged by moderation."), outcome="refused", cause=FILTERED
    ),
    "broken": always(
        error(500, "broken"), outcome="error", cause="InternalServerError: Error code: 500"
    ),
    "busy": always(error(429, "slow down"), outcome="error", cause="RateLimitError: Error code: 429"),
    "dropped": always((0, b""), outcome="error", cause="APIConnectionError: Connection error"),
    "bad request": always(error(400, "too many images"), outcome="error", cause="BadRequestError: Error code: 400"),
    "garbage": always(
        (200, b"<html>welcome</html>"), outcome="error",
        cause="not a chat completion: Expecting value: line 1 column 1",
    ),
    "no choices": always(
        (200, {"id": "c", "object": "chat.completion", "created": 1, "model": "m", "choices": []}),
        outcome="error", cause="the response has no choices",
    ),
    "slow": Manner(_slow, outcome="error", cause="APITimeoutError: Request timed out"),
}  # fmt: skip


@dataclass
class Server:
    """A running server of a manner; `takes` returns the label that the model takes, for the parts of a turn."""

    takes: Callable[[list[Any]], str]
    address: str = ""
    tries: Counter[str] = field(default_factory=Counter)
    lock: threading.Lock = field(default_factory=threading.Lock)


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *args: object) -> None:
        """Nothing is printed."""

    def do_POST(self) -> None:
        raw = self.rfile.read(int(self.headers["Content-Length"]))
        body = json.loads(raw)
        mine: Server = self.server.mine  # type: ignore[attr-defined]
        turn = json.dumps(body["messages"])
        with mine.lock:
            mine.tries[turn] += 1
            tries = mine.tries[turn]
        parts = body["messages"][-1]["content"]
        manner = MANNERS[body["model"].split("/")[-1].replace("_", " ")]
        status, answer = manner.respond(mine.takes(parts), body, tries)
        if not status:
            self.close_connection = True
            self.connection.close()
            return
        content = answer if isinstance(answer, bytes) else json.dumps(answer).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Retry-After", "0.01")
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)


class _Http(ThreadingHTTPServer):
    daemon_threads = True
    request_queue_size = 256

    def handle_error(self, request: object, client_address: object) -> None:
        """A client that hangs up is no news."""


@contextmanager
def server(takes: Callable[[list[Any]], str]) -> Iterator[Server]:
    """A server on a free port, until the block ends."""
    mine, http = Server(takes), _Http(("127.0.0.1", 0), _Handler)
    http.mine = mine  # type: ignore[attr-defined]
    with serving(http) as mine.address:
        yield mine


def first_words(parts: list[Any]) -> str:
    """The label of the first option in words, whatever it is: what a model without knowledge takes."""
    shown = "\n".join(part["text"] for part in parts if part["type"] == "text")
    return re.findall(r"(?m)^([A-Z])\. ", shown)[0]
