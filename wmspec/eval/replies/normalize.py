"""Text of a reply without reasoning and markup."""

from __future__ import annotations

import re
import unicodedata

#: Maximum number of characters of a reply that are read.
MAX_REPLY_LENGTH = 65_536

_TAGS = r"think|thinking|thought|thoughts|reasoning|reason|scratchpad|reflection|analysis|seed:think|inner_monologue"
#: Begin and end of reasoning, by the models that write it: DeepSeek, Qwen and others; Kimi; Magistral; Sky-T1; Harmony.
_REASONING = (
    (rf"<(?:{_TAGS})>", rf"</(?:{_TAGS})>"),
    ("◁think▷", "◁/think▷"),
    (r"\[THINK\]", r"\[/THINK\]"),
    (r"<\|begin_of_thought\|>", r"<\|end_of_thought\|>"),
    (r"<\|channel\|>\s*(?:analysis|commentary)\b[^<]*<\|message\|>", r"<\|channel\|>\s*final\b[^<]*<\|message\|>"),
)
_CONTROL = re.compile(r"<\|(?:start|end|return|channel|message|begin_of_solution|end_of_solution|im_end|eot_id)\|>")
#: Harmony's channels after a decoder that drops control tokens.
_BARE_CHANNELS = re.compile(r"(?s)^\s*analysis(?=\S).*assistantfinal")

_ANSWER_TAGS = (
    re.compile(r"(?is)<(?:final_?)?answer>(.{0,500}?)</(?:final_?)?answer>"),
    re.compile(r"(?s)<\|begin_of_box\|>(.{0,500}?)<\|end_of_box\|>"),
    re.compile(r"\\boxed\s*\{([^{}]{0,500})\}"),
)
_JSON_ANSWER = re.compile(
    r"(?i)[\"'](?:final_?|correct_?)?(?:answer|choice|option|label|letter|prediction)[\"']\s*:\s*[\"']?([^\"',}\n]{1,200})"
)
#: Control, format and replacement characters.
_INVISIBLE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\xad\u200b-\u200f\u202a-\u202e\u2060-\u206f\ufeff\ufffd]")
_HEADING = re.compile(
    r"(?im)^[\s*#_>]*((?:final |correct )?answer|antwort|réponse|respuesta|答案|答え)[\s*:：#_]*\n+\s*"
)


def normalize(text: str) -> str:
    """Return a reply without reasoning and markup, with normalized characters.

    Answers in tags, boxes and JSON become announcements ("Answer: B").
    """
    reply = unicodedata.normalize("NFKC", _INVISIBLE.sub("", text[-MAX_REPLY_LENGTH:]))
    reply = _without_reasoning(reply)
    reply = re.sub(r"\\(?:text|textbf|mathrm|mathbf|rm)\s*\{([^{}]*)\}", r"\1", reply)
    for tag in _ANSWER_TAGS:
        reply = tag.sub(lambda match: f"\nAnswer: {' '.join(match[1].split())}\n", reply)
    reply = _JSON_ANSWER.sub(lambda match: f"\nAnswer: {match[1].strip()}\n", reply)
    reply = _HEADING.sub(r"\1: ", reply)
    reply = re.sub(r"<[a-zA-Z/][^<>\n]{0,40}>", " ", reply)
    reply = re.sub(r"(?<![^\W_])_+|_+(?![^\W_])", "", re.sub(r"[*`$#“”„«»\"‘]|\\[()\[\]]|^\s*>", "", reply))
    return reply.replace("’", "'").replace("−", "-").replace("‑", "-").strip()


def _without_reasoning(reply: str) -> str:
    """Return a reply after its reasoning; one that only reasons, without an end, is empty."""
    for begin, end in _REASONING:
        ends = list(re.finditer(rf"(?i){end}", reply))
        if ends:
            reply = _kept_before(reply[: ends[-1].start()], begin) + reply[ends[-1].end() :]
        reply = re.split(rf"(?i){begin}", reply, maxsplit=1)[0]
    reply = _BARE_CHANNELS.sub("", reply)
    return _CONTROL.sub(" ", reply)


def _kept_before(reply: str, begin: str) -> str:
    """Return what precedes the reasoning; nothing if its begin is missing, as with templates that open it."""
    parts = re.split(rf"(?i){begin}", reply, maxsplit=1)
    return parts[0] + " " if len(parts) == 2 else ""
