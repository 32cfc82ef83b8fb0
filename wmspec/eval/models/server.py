"""Models behind an OpenAI-compatible server, by the `openai` client, which retries transient errors."""

from __future__ import annotations

import base64
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any
from urllib.parse import urlsplit

from wmspec.core.diagnostics import WmsError
from wmspec.eval.models.model import FatalModelError, Reply, storable
from wmspec.eval.models.request import Ask, Clip, Picture, Request, Text

#: Environment variables with the key of a server, and with the server if none is named.
KEY_VARIABLE, ADDRESS_VARIABLE = "OPENAI_API_KEY", "OPENAI_BASE_URL"
_OPENAI = "https://api.openai.com/v1"
#: Maximum size of a response (bytes), far above a reply of `LONGEST` characters.
MAX_RESPONSE_BYTES = 4 << 20


@dataclass(frozen=True)
class Server:
    """The connection to a server.

    Its address, timeout (s), number of retries, and the prices of a million tokens, sent and received.
    """

    address: str
    timeout: float = 120.0
    retries: int = 5
    prices: tuple[float, float] | None = None


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
    """A model of a server. `parameters` are part of every request."""

    def __init__(self, name: str, server: Server, parameters: dict[str, Any], asks: int) -> None:
        """Create the client. Raises WmsError if the client package or the key is missing."""
        try:
            import openai
        except ImportError:
            raise WmsError("this needs the openai client; install it with `pip install 'wmspec[evaluate]'`") from None
        self.identity = f"{server.address} {name}"
        self.asks = asks
        self._name, self._server, self._parameters = name, server, parameters
        self._key = os.environ.get(KEY_VARIABLE, "")
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

    def reply(self, ask: Ask) -> Reply:
        """Return the server's reply, or the error after all retries. Raises Lost if no request can succeed."""
        import openai

        messages, began = _messages(ask.request), time.monotonic()
        try:
            done = self._client.chat.completions.create(
                model=self._name, messages=messages, extra_body=self._parameters
            )
            reply = self._read(done)
        except (openai.AuthenticationError, openai.PermissionDeniedError, openai.NotFoundError) as error:
            raise FatalModelError(
                f"{self._server.address} refuses `{self._name}`: {self._hidden(str(error))}"
            ) from None
        except openai.OpenAIError as error:
            reply = Reply(outcome="error", error=self._hidden(_cause(error)))
        except (ValueError, TypeError, LookupError, AttributeError) as error:
            reply = Reply(outcome="error", error=self._hidden(f"not a chat completion: {error}"))
        return replace(reply, seconds=round(time.monotonic() - began, 3))

    def _read(self, done: Any) -> Reply:
        """Return the reply in a response. Raises ValueError and others if it is no chat completion."""
        if not done.choices:
            return Reply(outcome="error", error="the response has no choices")
        chosen = done.choices[0]
        text = chosen.message.content
        withheld = chosen.finish_reason == "content_filter" or getattr(chosen.message, "refusal", None)
        version = "/".join(str(part) for part in (done.model, getattr(done, "system_fingerprint", None)) if part)
        return Reply(
            text=self._hidden(storable(text if isinstance(text, str) else "")),
            outcome="refused" if withheld else "ok",
            model_version=self._hidden(storable(version)[:200]) or None,
            **self._usage(done.usage),
        )

    def _usage(self, usage: Any) -> dict[str, Any]:
        if usage is None:
            return {}
        sent, received = _count(usage.prompt_tokens), _count(usage.completion_tokens)
        cost = (usage.model_extra or {}).get("cost")
        if self._server.prices is not None:
            cost = (sent or 0) * self._server.prices[0] / 1e6 + (received or 0) * self._server.prices[1] / 1e6
        return {
            "tokens_in": sent,
            "tokens_out": received,
            "cost": float(cost) if isinstance(cost, (int, float)) else None,
        }

    def _hidden(self, text: str) -> str:
        """Return a text with the key removed, in case a server echoes it."""
        return text.replace(self._key, "[key]") if self._key else text


def _count(value: Any) -> int | None:
    return value if isinstance(value, int) and 0 <= value < 1 << 62 else None


def _cause(error: BaseException) -> str:
    message = f"{type(error).__name__}: {error}"
    if error.__cause__ is not None and str(error.__cause__) not in message:
        message += f" ({error.__cause__})"
    return storable(message)[:2000]


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


def _messages(request: Request) -> Any:
    turn: list[dict[str, Any]] = []
    for part in request.parts:
        match part:
            case Text(text):
                turn.append({"type": "text", "text": text})
            case Picture(png):
                turn.append({"type": "image_url", "image_url": {"url": _data("image/png", png)}})
            case Clip(mp4):
                turn.append({"type": "video_url", "video_url": {"url": _data("video/mp4", mp4)}})
    system = [{"role": "system", "content": request.system}] if request.system else []
    return [*system, {"role": "user", "content": turn}]


def _data(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
