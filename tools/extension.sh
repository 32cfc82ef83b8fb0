#!/usr/bin/env bash
# Packages editors/vscode: `tools/extension.sh OUT.vsix`. Needs node and npm. Other output goes to build/vscode.
set -euo pipefail
out=$(realpath -m "${1:-build/wmspec.vsix}")
cd "$(dirname "$0")/.."
mkdir -p build/vscode "$(dirname "$out")"
cp -R editors/vscode/. build/vscode/
cd build/vscode
npm install --no-audit --no-fund --loglevel=error
npx vsce package --no-dependencies --allow-missing-repository --out "$out"
