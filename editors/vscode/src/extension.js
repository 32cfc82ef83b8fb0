// The client: it starts the language server, and shows what that draws.
const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

async function start() {
  const [command, ...args] = vscode.workspace.getConfiguration("wmspec").get("command");
  const folder = vscode.workspace.workspaceFolders?.[0]?.uri.fsPath;
  const server = { command, args, options: { cwd: folder } };
  client = new LanguageClient("wmspec", "wmspec", server, { documentSelector: [{ language: "wms" }] });
  try {
    await client.start();
  } catch (error) {
    const remedy = "Install it with: pip install 'wmspec[lsp]', or set wmspec.command.";
    vscode.window.showErrorMessage(`wmspec's language server does not start: ${error.message}. ${remedy}`);
  }
}

async function preview() {
  const editor = vscode.window.activeTextEditor;
  if (editor?.document.languageId !== "wms") return;
  const { line, character } = editor.selection.active;
  const drawn = await vscode.window.withProgress(
    { location: vscode.ProgressLocation.Window, title: "wmspec draws" },
    () =>
      client
        .sendRequest("workspace/executeCommand", {
          command: "wmspec.preview",
          arguments: [editor.document.uri.toString(), { line, character }],
        })
        .catch((error) => void vscode.window.showErrorMessage(error.message)),
  );
  if (!drawn) return;
  await vscode.commands.executeCommand("vscode.open", vscode.Uri.parse(drawn.uri), {
    viewColumn: vscode.ViewColumn.Beside,
    preserveFocus: true,
    preview: true,
  });
  vscode.window.setStatusBarMessage(`${drawn.task} ${drawn.instance}: ${drawn.factors}`, 10000);
}

exports.activate = async (context) => {
  context.subscriptions.push(
    vscode.commands.registerCommand("wmspec.showPreview", preview),
    vscode.commands.registerCommand("wmspec.restart", async () => {
      await client?.stop();
      await start();
    }),
  );
  await start();
};

exports.deactivate = () => client?.stop();
