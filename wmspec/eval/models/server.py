"""Models behind an OpenAI-compatible server, by the `openai` client, which retries transient errors."""

from __future__ import annotations

import json
import os
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any
from urllib.parse import quote, urlsplit

from wmspec.core.diagnostics import WmsError
from wmspec.dataset.build.images import data_url
from wmspec.eval.models.images import AS_THEY_ARE, ImageOptions
from wmspec.eval.models.message import Parameters, read_response, response_format
from wmspec.eval.models.model import FatalModelError, Reply, storable
from wmspec.eval.models.request import Ask, Clip, Picture, Request, Text
from wmspec.eval.replies import is_withheld

#: Environment variables with the key of a server, and with the server if none is named.
KEY_VARIABLE, ADDRESS_VARIABLE = "OPENAI_API_KEY", "OPENAI_BASE_URL"
_OPENAI = "https://api.openai.com/v1"
#: Minimum length of a key that is hidden; shorter ones, such as "none", are placeholders, and words of replies.
MIN_KEY_LENGTH = 8
#: Words for a quota that is used up.
_EXHAUSTED = re.compile(
    r"(?i)insufficient_quota|exceeded your current quota|insufficient (?:balance|credits?)|credit balance"
)
#: Maximum size of a response (bytes), far above a reply of `MAX_REPLY_LENGTH` characters.
MAX_RESPONSE_BYTES = 4 << 20


@dataclass(frozen=True)
class Server:
    """The connection to a server.

    Its address, timeout (s), number of retries, the prices of a million tokens, sent and received, how pictures are
    sent, and whether answers are constrained by a schema (`structured`).
    """

    address: str
    timeout: float = 120.0
    retries: int = 5
    prices: tuple[float, float] | None = None
    images: ImageOptions = AS_THEY_ARE
    structured: bool = False


def address(base_url: str | None) -> str:
    """Return the address of the server. Raises WmsError for one that contains a key, or is invalid."""
    url = base_url or os.environ.get(ADDRESS_VARIABLE) or _OPENAI
    parts = urlsplit(url)
    if parts.scheme not in {"http", "https"} or not parts.hostname:
        raise WmsError("--base-url: expected an address such as http://localhost:8000/v1")
    if parts.username or parts.password or parts.query or parts.fragment:
        raise WmsError(
            f"--base-url: an address without user, key or question mark; the key belongs into {KEY_VARIABLE}"
        )
    return url.rstrip("/")


class ServerModel:
    """A model of a server. `parameters` are part of every request; those in `defaults` may be left out or renamed."""

    def __init__(
        self, name: str, server: Server, parameters: dict[str, Any], asks: int, defaults: frozenset[str] = frozenset()
    ) -> None:
        """Create the client. Raises WmsError if the client package or the key is missing, or the key is no key."""
        try:
            import openai
        except ImportError:
            raise WmsError("this needs the openai client; install it with `pip install 'wmspec[evaluate]'`") from None
        structured = "structured" if server.structured else ""
        self.identity = " ".join(filter(None, (server.address, name, server.images.record, structured)))
        self.asks = asks
        self._name, self._server, self._parameters = name, server, Parameters(parameters, defaults)
        self._key = os.environ.get(KEY_VARIABLE, "").strip()
        if not (self._key.isascii() and self._key.isprintable()):
            raise WmsError(f"{KEY_VARIABLE} has characters that no key has; set it again")
        if not self._key and server.address == _OPENAI:
            raise WmsError(
                f"the key is missing: set {KEY_VARIABLE} in the environment, or name another server with --base-url"
            )
        self._client = openai.OpenAI(
            api_key=self._key or "none",
            base_url=server.address,
            timeout=server.timeout,
            max_retries=server.retries,
            http_client=_client(openai),
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What was changed in requests because the server rejected it."""
        return self._parameters.notes

    def reply(self, ask: Ask) -> Reply:
        """Return the server's reply, or the error after all retries.

        Raises FatalModelError if no request can succeed.
        """
        messages, began = _messages(ask.request, self._server.images), time.monotonic()
        form = response_format(ask) if self._server.structured else None
        reply = self._try(messages, {"response_format": form} if form else {})
        return replace(reply, seconds=round(time.monotonic() - began, 3))

    def _try(self, messages: Any, form: dict[str, Any]) -> Reply:
        """Return the reply to messages, tried again without the parameters that the server rejects."""
        import openai

        sent = self._parameters.values
        try:
            done = self._client.chat.completions.create(model=self._name, messages=messages, extra_body=sent | form)
            return replace(read_response(done, self._hidden), **self._usage(done.usage))
        except openai.BadRequestError as error:
            if self._parameters.learn(sent, str(error)):
                return self._try(messages, form)
            return self._failure(error)
        except openai.OpenAIError as error:
            return self._failure(error)
        except (ValueError, TypeError, LookupError, AttributeError) as error:
            return Reply(error=storable(self._hidden(f"not a chat completion: {error}"))[:2000])

    def _failure(self, error: Any) -> Reply:
        """Return the reply for an error. Raises FatalModelError if every request will end like this one."""
        import openai

        message = storable(self._hidden(_cause(error)))[:2000]
        if isinstance(error, openai.APIStatusError) and is_withheld(error.status_code, message):
            return Reply(finish="content_filter", error=message)
        if isinstance(error, (openai.AuthenticationError, openai.PermissionDeniedError, openai.NotFoundError)):
            raise FatalModelError(f"{self._server.address} refuses `{self._name}`: {message}")
        if _EXHAUSTED.search(message):
            raise FatalModelError(f"the quota is used up at {self._server.address}: {message}")
        return Reply(error=message)

    def _usage(self, usage: Any) -> dict[str, Any]:
        if usage is None:
            return {}
        sent, received = _count(usage.prompt_tokens), _count(usage.completion_tokens)
        cost = (usage.model_extra or {}).get("cost")
        details = getattr(usage, "completion_tokens_details", None)
        if self._server.prices is not None:
            cost = (sent or 0) * self._server.prices[0] / 1e6 + (received or 0) * self._server.prices[1] / 1e6
        return {
            "tokens_in": sent,
            "tokens_out": received,
            "tokens_reasoning": _count(getattr(details, "reasoning_tokens", None)),
            "cost": float(cost) if isinstance(cost, (int, float)) else None,
        }

    def _hidden(self, text: str) -> str:
        """Return a text without the key, in case a server echoes it, as it is or escaped."""
        if len(self._key) < MIN_KEY_LENGTH:
            return text
        forms = {self._key, json.dumps(self._key)[1:-1], self._key.replace("/", "\\/"), quote(self._key, safe="")}
        for form in sorted(forms, key=len, reverse=True):
            text = text.replace(form, "[key]")
        return text


def _count(value: Any) -> int | None:
    return value if isinstance(value, int) and 0 <= value < 1 << 62 else None


def _cause(error: BaseException) -> str:
    message = f"{type(error).__name__}: {error}"
    if error.__cause__ is not None and str(error.__cause__) not in message:
        message += f" ({error.__cause__})"
    return message


def _client(openai: Any) -> Any:
    """Return a client that reads at most `MAX_RESPONSE_BYTES` bytes of a response."""
    import httpx2

    class Bounded(httpx2.SyncByteStream):  # type: ignore[misc]
        def __init__(self, stream: Any) -> None:
            self._stream = stream

        def __iter__(self) -> Iterator[bytes]:
            total = 0
            for chunk in self._stream:
                total += len(chunk)
                if total > MAX_RESPONSE_BYTES:
                    raise httpx2.DecodingError(f"an answer of more than {MAX_RESPONSE_BYTES:,} bytes")
                yield chunk

        def close(self) -> None:
            self._stream.close()

    class Transport(httpx2.HTTPTransport):  # type: ignore[misc]
        def handle_request(self, request: Any) -> Any:
            # Refuse compression, which could hide a huge response.
            request.headers["Accept-Encoding"] = "identity"
            response = super().handle_request(request)
            response.stream = Bounded(response.stream)
            return response

    limits = httpx2.Limits(max_connections=256, max_keepalive_connections=64)
    return openai.DefaultHttpxClient(transport=Transport(limits=limits, retries=0))


def _messages(request: Request, images: ImageOptions) -> Any:
    turn: list[dict[str, Any]] = []
    for part in request.parts:
        match part:
            case Text(text):
                turn.append({"type": "text", "text": text})
            case Picture(png):
                detail = {"detail": images.detail} if images.detail else {}
                turn.append({"type": "image_url", "image_url": {"url": data_url(*images.encode(png)), **detail}})
            case Clip(mp4):
                turn.append({"type": "video_url", "video_url": {"url": data_url("video/mp4", mp4)}})
    system = [{"role": "system", "content": request.system}] if request.system else []
    return [*system, {"role": "user", "content": turn}]
