"""The language server in a real session: a client of its own process, over standard input and output."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

import pytest

lsp = pytest.importorskip("lsprotocol.types")
from pygls.lsp.client import LanguageClient  # noqa: E402  it may not be here

from tests.engines import installed  # noqa: E402
from wmspec.api.loading import diagnose  # noqa: E402
from wmspec.core.places import Source  # noqa: E402
from wmspec.editor.start import first_spec  # noqa: E402
from wmspec.lang.parse.files import library_folder  # noqa: E402
from wmspec.lang.parse.format import format_spec  # noqa: E402

T = TypeVar("T")
PATIENCE = 300.0  # s: what ends a test that hangs, and no test of how busy the machine is
GOOD = first_spec("marbles", "prediction")


class Session:
    """An editor with one document open."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.path = folder / "marbles.wms"
        self.client: Any = LanguageClient("tests", "1")
        self.text = ""
        self.version = 0
        self.published: asyncio.Queue[Any] = asyncio.Queue()

        @self.client.feature(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def reported(params: Any) -> None:
            self.published.put_nowait(params)

    @property
    def uri(self) -> str:
        return self.path.as_uri()

    @property
    def document(self) -> Any:
        return lsp.TextDocumentIdentifier(self.uri)

    async def start(self) -> None:
        await self.client.start_io(sys.executable, "-m", "wmspec", "lsp")
        folders = [lsp.WorkspaceFolder(self.folder.as_uri(), "folder")]
        root = lsp.InitializeParams(lsp.ClientCapabilities(), workspace_folders=folders)
        self.can = (await self.client.initialize_async(root)).capabilities
        self.client.initialized(lsp.InitializedParams())

    async def stop(self) -> None:
        await self.client.shutdown_async(None)
        self.client.exit(None)
        await self.client.stop()

    def open(self, text: str) -> None:
        self.text = text
        self.path.write_text(text)
        item = lsp.TextDocumentItem(self.uri, "wms", self.version, text)
        self.client.text_document_did_open(lsp.DidOpenTextDocumentParams(item))

    def close(self) -> None:
        self.client.text_document_did_close(lsp.DidCloseTextDocumentParams(self.document))
        self.version += 1

    def edit(self, old: str, new: str) -> None:
        """Type `new` over the first `old`: one incremental change."""
        start = self.text.index(old)
        change = lsp.TextDocumentContentChangePartial(
            range=lsp.Range(self.at(start), self.at(start + len(old))), text=new
        )
        self.version += 1
        self.text = self.text[:start] + new + self.text[start + len(old) :]
        where = lsp.VersionedTextDocumentIdentifier(version=self.version, uri=self.uri)
        self.client.text_document_did_change(lsp.DidChangeTextDocumentParams(where, [change]))

    def at(self, offset: int) -> Any:
        """A position in UTF-16 units, as the protocol counts."""
        before = self.text[:offset]
        column = before[before.rfind("\n") + 1 :]
        return lsp.Position(before.count("\n"), len(column.encode("utf-16-le")) // 2)

    def after(self, text: str) -> Any:
        return self.at(self.text.index(text) + len(text))

    def slice(self, where: Any) -> str:
        lines = self.text.split("\n")
        assert where.start.line == where.end.line
        return lines[where.start.line][where.start.character : where.end.character]

    async def diagnostics(self, done: Callable[[list[Any]], bool]) -> list[Any]:
        """The first diagnostics of the text as it is now of which this is so."""
        while True:
            params = await asyncio.wait_for(self.published.get(), PATIENCE)
            if params.uri == self.uri and params.version == self.version and done(params.diagnostics):
                found: list[Any] = params.diagnostics
                return found

    async def offers(self, after: str) -> list[str]:
        params = lsp.CompletionParams(self.document, self.after(after))
        listed = await self.client.text_document_completion_async(params)
        return [item.label for item in listed.items]

    async def hover(self, after: str) -> str:
        about = await self.client.text_document_hover_async(lsp.HoverParams(self.document, self.after(after)))
        return str(about.contents.value) if about else ""


def session(folder: Path, work: Callable[[Session], Awaitable[T]]) -> T:
    async def whole() -> T:
        editor = Session(folder)
        await editor.start()
        try:
            return await asyncio.wait_for(work(editor), PATIENCE)
        finally:
            await editor.stop()

    with ThreadPoolExecutor(1) as apart:  # the loop of a browser's tests may be running in this thread
        return apart.submit(asyncio.run, whole()).result()


def test_diagnostics_come_as_one_types(tmp_path: Path) -> None:
    async def work(editor: Session) -> None:
        editor.open(GOOD)
        assert not await editor.diagnostics(lambda _: True)
        editor.edit("density: 200", "desnity: 200")
        (mistake,) = await editor.diagnostics(bool)
        editor.path.write_text(editor.text)
        (checked,) = diagnose(editor.path).diagnostics
        assert mistake.message == f"{checked.message}\nhelp: {checked.help}"
        assert (mistake.code, editor.slice(mistake.range)) == ("WMS203", "desnity")
        assert mistake.code_description.href.endswith("/WMS203.md")
        params = lsp.CodeActionParams(editor.document, mistake.range, lsp.CodeActionContext([mistake]))
        fix, trial = await editor.client.text_document_code_action_async(params)
        assert "wmspec.try" in str(trial.command)
        assert fix.title == "write `density`"
        ((edit,),) = fix.edit.changes.values()
        assert (editor.slice(edit.range), edit.new_text) == ("desnity", "density")
        editor.edit("desnity", "density")
        assert not await editor.diagnostics(lambda found: not found)
        editor.edit("object block", "object ball")  # another place is involved
        twice = await editor.diagnostics(lambda found: any(d.code == "WMS202" for d in found))
        related = [r for d in twice if d.code == "WMS202" for r in d.related_information or ()]
        assert editor.slice(related[0].location.range) == "ball"

    session(tmp_path, work)


BROKEN = (
    "", "task", "task a : b { object x {", '"""', "}}}}", 'question "', "\N{SMILING FACE WITH OPEN MOUTH} x", "\x00",
)  # fmt: skip


def test_broken_texts_break_nothing(tmp_path: Path) -> None:
    async def ask_all(editor: Session, broken: str) -> None:
        editor.open(broken)
        end = editor.at(len(broken))
        await editor.diagnostics(lambda _: True)
        for ask, params in (
            (editor.client.text_document_completion_async, lsp.CompletionParams(editor.document, end)),
            (editor.client.text_document_hover_async, lsp.HoverParams(editor.document, end)),
            (editor.client.text_document_definition_async, lsp.DefinitionParams(editor.document, end)),
            (editor.client.text_document_document_symbol_async, lsp.DocumentSymbolParams(editor.document)),
            (
                editor.client.text_document_formatting_async,
                lsp.DocumentFormattingParams(editor.document, lsp.FormattingOptions(2, True)),
            ),
        ):
            await ask(params)

    async def work(editor: Session) -> None:
        for broken in BROKEN:
            await ask_all(editor, broken)
            editor.close()

    session(tmp_path, work)


def test_completion_is_by_kind(tmp_path: Path) -> None:
    async def work(editor: Session) -> None:
        editor.open(GOOD)
        libraries = await editor.offers("use ")
        assert "tabletop" in libraries
        assert "collide" not in libraries, "a spec with a task is no library"
        properties = await editor.offers("object block { ")
        assert {"shape", "friction", "part"} <= {*properties}
        assert "fov" not in properties
        assert "shape" not in await editor.offers("object block { shape: cube  "), "it is said already"
        assert (await editor.offers("shape: "))[0] == "sphere" or "sphere" in await editor.offers("shape: ")
        assert "red" not in await editor.offers("shape: ")
        assert (await editor.offers("color: "))[0] == "tint", "a name of that type comes first"
        assert "wood" not in await editor.offers("color: ")
        assert (await editor.offers("let speed_of_0 = 50 cm/s\n  let step       = "))[0] in ("floor", "level", "front")
        arguments = await editor.offers("launch(ball, ")
        assert {"direction", "speed", "rolling"} <= {*arguments}
        assert "object" not in arguments[:3]
        assert "launch" in await editor.offers("action push = ")
        assert {*await editor.offers("answer frame(")} >= {"front", "top"}
        assert "ball" not in await editor.offers("answer frame(")
        assert (await editor.offers("action push.")) == ["object", "direction", "speed", "climb", "rolling", "start"]
        assert "ball" in await editor.offers("contact(")
        editor.edit("size: 14 cm", "size: 14 ")
        units = await editor.offers("size: 14 ")
        assert units[:3] == ["mm", "cm", "dm"]
        assert "kg" not in units
        editor.edit("speed: speed_of_0 + step * level,", "speed: 20 ,")
        assert {*await editor.offers("speed: 20 ")} >= {"cm/s", "m/s"}
        statements = await editor.offers("repeat 10\n\n  ")
        assert {"object", "question", "factor"} <= {*statements}
        assert "options" not in statements
        editor.edit("ensure   contact", "contact")
        assert {"ensure", "margin"} <= {*await editor.offers("mod(level + 2, 3) }\n    ")}
        editor.edit("    contact", "    ensure   contact")
        assert await editor.offers("# 0 is sl") == [], "a comment"

    session(tmp_path, work)


def test_hover_equals_the_reference(tmp_path: Path) -> None:
    async def work(editor: Session) -> None:
        editor.open(GOOD)
        assert "mass per volume" in await editor.hover("densi")
        assert "initial speed" in await editor.hover("(block), spee")
        assert "gives the object a velocity" in await editor.hover("push = lau")
        assert "whether two objects touch" in await editor.hover("conta")
        assert "unit of speed" in await editor.hover("50 cm")
        assert "a color" in await editor.hover("[re")
        assert "let step" in await editor.hover("speed_of_0 + st")
        assert "such as `20 cm/s`" in await editor.hover("speed_of_0 + st")
        assert "A wide floor" in await editor.hover("use ro")
        assert "in domain" in await editor.hover("  fac")
        assert "measured on the executed episode" in await editor.hover("    answ")

    session(tmp_path, work)


def test_definitions_lead_into_libraries_and_names_change_everywhere(tmp_path: Path) -> None:
    async def work(editor: Session) -> None:
        (tmp_path / "things.wms").write_text(
            "template crate(tone: red) { shape: cube  color: tone }\nobject plate { size: 10 cm  at: (0, 0, 5 cm) }\n"
        )
        other = tmp_path / "other.wms"
        other.write_text(
            GOOD.replace("use room", "use room\nuse things").replace("on: floor at (0, lane)", "on: plate")
        )
        editor.open(GOOD.replace("use room", "use room\nuse things as mine  # \N{GRINNING FACE}").replace(
            "on: floor at (0, lane)", "on: mine.plate"))  # fmt: skip

        async def definition(after: str) -> Any:
            return await editor.client.text_document_definition_async(
                lsp.DefinitionParams(editor.document, editor.after(after))
            )

        async def references(after: str) -> list[Any]:
            context = lsp.ReferenceContext(include_declaration=True)
            params = lsp.ReferenceParams(context, editor.document, editor.after(after))
            found: list[Any] = await editor.client.text_document_references_async(params)
            return found

        async def rename(after: str, name: str) -> dict[str, list[Any]]:
            params = lsp.RenameParams(text_document=editor.document, position=editor.after(after), new_name=name)
            edit = await editor.client.text_document_rename_async(params)
            changes: dict[str, list[Any]] = edit.changes
            return changes

        there = await definition("observe fro")
        assert there.uri == (library_folder() / "room_views.wms").resolve().as_uri()
        assert (await definition("mine.pla")).uri == (tmp_path / "things.wms").as_uri()
        assert (await definition("use ro")).range.start.line == 0
        tints = await references("factor   ti")
        assert [editor.slice(place.range) for place in tints] == ["tint"] * 3, "in the text of the question too"
        changes = await rename("mine.pla", "dish")
        assert {Path(uri.removeprefix("file://")).name for uri in changes} == {"marbles.wms", "things.wms", "other.wms"}
        (edit,) = changes[editor.uri]
        assert editor.slice(edit.range) == "plate"
        changes = await rename("factor   ti", "shade_of_ball")
        text = editor.text
        for edit in sorted(changes[editor.uri], key=lambda e: (-e.range.start.line, -e.range.start.character)):
            lines = text.split("\n")
            line = lines[edit.range.start.line]
            lines[edit.range.start.line] = (
                line[: edit.range.start.character] + edit.new_text + line[edit.range.end.character :]
            )
            text = "\n".join(lines)
        editor.path.write_text(text)
        assert diagnose(editor.path).passed
        for after, name, reported in (
            ("observe fro", "ahead", "a library of wmspec"),
            ("factor   ti", "ball", "already"),
            ("factor   ti", "factor", "a word of the language"),
            ("factor   ti", "no-name", "not a name"),
        ):
            with pytest.raises(Exception, match=reported):
                await rename(after, name)

    session(tmp_path, work)


def test_symbols_and_formatting(tmp_path: Path) -> None:
    async def work(editor: Session) -> None:
        editor.open(GOOD.replace("  object ball  {", "object    ball{"))
        (task,) = await editor.client.text_document_document_symbol_async(lsp.DocumentSymbolParams(editor.document))
        assert task.name == "marbles"
        assert {"level", "ball", "block", "push"} <= {child.name for child in task.children}
        options = lsp.DocumentFormattingParams(editor.document, lsp.FormattingOptions(2, True))
        (edit,) = await editor.client.text_document_formatting_async(options)
        assert edit.new_text == format_spec(Source("x", editor.text)) != editor.text
        assert edit.range.start == lsp.Position(0, 0)

    session(tmp_path, work)


@pytest.mark.engine
@pytest.mark.pixels
def test_the_instance_under_the_cursor_is_drawn(tmp_path: Path) -> None:
    installed("mujoco")

    async def work(editor: Session) -> tuple[dict[str, Any], bytes]:
        editor.open(GOOD)
        where = editor.after("[0, 1, ")
        position = {"line": where.line, "character": where.character}
        params = lsp.ExecuteCommandParams(command="wmspec.preview", arguments=[editor.uri, position])
        drawn = await editor.client.workspace_execute_command_async(params)
        answer = drawn if isinstance(drawn, dict) else vars(drawn) if hasattr(drawn, "__dict__") else drawn._asdict()
        editor.edit("launch(", "lunch(")
        with pytest.raises(Exception, match="no verb `lunch`"):
            await editor.client.workspace_execute_command_async(params)
        return answer, Path(answer["uri"].removeprefix("file://")).read_bytes()

    answer, png = session(tmp_path, work)
    assert answer["task"] == "marbles"
    assert answer["factors"].startswith("level = 2")
    assert png.startswith(b"\x89PNG")
    assert not Path(answer["uri"].removeprefix("file://")).exists(), "what was drawn is removed at the end"
