"""Local models, run by `transformers`."""

from __future__ import annotations

import hashlib
import threading
import time
from pathlib import Path
from typing import Any

from wmspec.core.diagnostics import WmsError
from wmspec.core.safe_io import read_bytes
from wmspec.eval.models.images import AS_THEY_ARE, ImageOptions, decode_image
from wmspec.eval.models.model import Reply, storable
from wmspec.eval.models.request import Ask, Clip, Picture, Request, Text

_INSTALL = "install it with `pip install 'wmspec[local]'`"


class LocalModel:
    """A vision-language model in a folder written by `save_pretrained`. It takes one request at a time."""

    asks = 1
    notes = ()

    def __init__(self, path: Path, parameters: dict[str, Any], images: ImageOptions = AS_THEY_ARE) -> None:
        """Load the model. Raises WmsError if transformers is missing or cannot load it."""
        try:
            import torch
            import transformers
        except ImportError as error:
            raise WmsError(f"hf:{path} needs {error.name}; {_INSTALL}") from None
        if not (path / "config.json").is_file():
            raise WmsError(f"hf:{path}: there is no config.json; name the folder that `save_pretrained` wrote")
        try:
            self._processor: Any = transformers.AutoProcessor.from_pretrained(
                path, local_files_only=True, trust_remote_code=False
            )
            self._model: Any = transformers.AutoModelForImageTextToText.from_pretrained(
                path, local_files_only=True, trust_remote_code=False, dtype="auto"
            ).eval()
        except (OSError, ValueError, ImportError, KeyError) as error:
            raise WmsError(f"hf:{path}: transformers cannot open it: {str(error).splitlines()[0]}") from None
        self._model.to("cuda" if torch.cuda.is_available() else "cpu")
        self._version = f"{self._model.config.model_type}:{_digest(path)}"
        self.identity = f"hf {self._version} transformers {transformers.__version__}"
        self._generation, self._images = _generation(parameters), images
        if images.record:
            self.identity += f" {images.record}"
        self._turn = threading.Lock()

    def reply(self, ask: Ask) -> Reply:
        """Return the generated text. Raises WmsError for a video, which not all models support."""
        import torch

        messages, began = _messages(ask.request, self._images), time.monotonic()
        with self._turn, torch.inference_mode():
            torch.manual_seed(ask.sample)
            try:
                batch = self._processor.apply_chat_template(
                    messages, add_generation_prompt=True, tokenize=True, return_dict=True, return_tensors="pt"
                ).to(self._model.device)
                sent = int(batch["input_ids"].shape[1])
                written = self._model.generate(**batch, **self._generation)[0, sent:]
            except (RuntimeError, ValueError, IndexError, TypeError) as error:
                return Reply(error=storable(f"{type(error).__name__}: {error}")[:2000])
            text = self._processor.decode(written, skip_special_tokens=True)
        limit = self._generation.get("max_new_tokens")
        return Reply(
            text=storable(text),
            finish="length" if limit is not None and len(written) >= limit else "stop",
            model_version=self._version,
            tokens_in=sent,
            tokens_out=len(written),
            seconds=round(time.monotonic() - began, 3),
        )


def _generation(parameters: dict[str, Any]) -> dict[str, Any]:
    """Return parameters by the names of `generate`."""
    options = dict(parameters)
    tokens, temperature = options.pop("max_tokens", 1024), options.pop("temperature", 0)
    warm = {"do_sample": True, "temperature": float(temperature)} if temperature else {"do_sample": False}
    return {"max_new_tokens": tokens, **warm, **options}


def _messages(request: Request, images: ImageOptions) -> list[dict[str, Any]]:
    turn: list[dict[str, Any]] = []
    for part in request.parts:
        match part:
            case Text(text):
                turn.append({"type": "text", "text": f"{text}\n"})
            case Picture(png):
                turn.append({"type": "image", "image": decode_image(images.encode(png)[1])})
            case Clip():
                raise WmsError("local models do not support videos; use another --prompt than `clip`")
    system = [{"role": "system", "content": [{"type": "text", "text": request.system}]}] if request.system else []
    return [*system, {"role": "user", "content": turn}]


def _digest(path: Path) -> str:
    """Return twelve hex digits that identify weights: names and sizes of all files, content of small ones."""
    digest = hashlib.sha256()
    for file in sorted(
        f for f in path.iterdir() if f.is_file() and f.suffix in {".json", ".safetensors", ".bin", ".jinja"}
    ):
        size = file.stat().st_size
        digest.update(f"{file.name} {size} ".encode())
        digest.update(read_bytes(file) if size < 64 << 20 else b"")
    return digest.hexdigest()[:12]
