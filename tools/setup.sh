#!/usr/bin/env bash
# Prepares a checkout: system packages (as root, on Debian and its children), then .venv with wmspec and its engines.
# Without root, or on another system, it prints the commands and goes on with what is there. Quick when all is done.
# `setup.sh --system` does the first half only: for root, when a user without root does the second.
# `setup.sh --browser` adds Chromium, for the tests of the gallery.
set -euo pipefail
cd "$(dirname "$0")/.."

VENV=.venv
STAMP=$VENV/wmspec-setup
LOG=$VENV/wmspec-setup.log
MESA=24.3 # the first Mesa whose software Vulkan draws SAPIEN's scenes
GL_PACKAGES=(libegl1 libgl1 libvulkan1)
MESA_PACKAGES=(mesa-vulkan-drivers libegl-mesa0 libgl1-mesa-dri)
# The entry points say which there are.
mapfile -t ENGINES < <(sed -n '/^\[project.entry-points/,/^$/s/ = .*//p' pyproject.toml)

say() { printf 'setup: %s\n' "$*"; }
complain() { printf 'setup: %s\n' "$*" >&2; }
have() { command -v "$1" >/dev/null 2>&1; }

# ---------------------------------------------------------------- system packages

apt_update() {
    [[ -n ${apt_is_fresh:-} ]] || apt-get update -qq
    apt_is_fresh=yes
}

# Installs packages, or prints the commands where it may not.
apt_install() {
    if ! have apt-get; then
        complain "this is not Debian; please install what it calls: $*"
        return 1
    elif [[ $(id -u) -ne 0 ]]; then
        complain "not root; please run:  sudo apt-get update && sudo apt-get install $*"
        return 1
    fi
    apt_update && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null
}

package_version() { dpkg-query -W -f='${db:Status-Status} ${Version}' "$1" 2>/dev/null | sed -n 's/^installed //p'; }

mesa_is_new() {
    local package version
    for package in "${MESA_PACKAGES[@]}"; do
        version=$(package_version "$package")
        [[ -n $version ]] && dpkg --compare-versions "$version" ge "$MESA" || return 1
    done
}

gl_is_there() {
    local package
    for package in "${GL_PACKAGES[@]}"; do [[ -n $(package_version "$package") ]] || return 1; done
    mesa_is_new
}

# shellcheck disable=SC2016  # apt expands these
suites() { apt-get indextargets --format '$(RELEASE)' 'Created-By: Packages' | sort -u; }

# Adds <codename>-backports with the address and the key of the machine's own Debian source.
add_backports() {
    local codename=$1 entry uri file key
    # shellcheck disable=SC2016  # apt expands these
    entry=$(apt-get indextargets --format '$(REPO_URI) $(SOURCESENTRY)' 'Created-By: Packages' "Release: $codename" | head -1)
    [[ -n $entry ]] || return 1
    uri=${entry%% *} file=${entry#* } file=${file%:*}
    key=$(grep -oiE 'signed-by[=:] */[^] ,]+' "$file" | head -1 | sed 's|^[^/]*||' || true)
    say "adding $codename-backports, for Mesa $MESA or newer"
    echo "deb ${key:+[signed-by=$key] }$uri $codename-backports main" \
        >"/etc/apt/sources.list.d/wmspec-$codename-backports.list"
    apt_is_fresh=
    apt_update
}

install_mesa() {
    local ID='' VERSION_CODENAME='' candidate target=()
    # shellcheck source=/dev/null
    . /etc/os-release
    apt_update
    candidate=$(apt-cache policy mesa-vulkan-drivers | sed -n 's/^ *Candidate: //p')
    if [[ $ID == debian ]] && dpkg --compare-versions "$candidate" lt "$MESA"; then
        suites | grep -qx "$VERSION_CODENAME-backports" || add_backports "$VERSION_CODENAME" || return 1
        target=(-t "$VERSION_CODENAME-backports")
    fi
    apt_install "${target[@]}" "${MESA_PACKAGES[@]}"
}

set_up_system() {
    if ! have dpkg-query || ! have apt-get; then
        complain "this is not Debian; SAPIEN draws with a GPU's Vulkan driver or Mesa >= $MESA, MuJoCo with EGL"
    elif gl_is_there; then
        return
    elif [[ $(id -u) -ne 0 ]]; then
        complain "the graphics libraries are incomplete or older than Mesa $MESA; please run:  sudo tools/setup.sh --system"
    else
        say "installing the graphics libraries"
        if ! { apt_install "${GL_PACKAGES[@]}" && install_mesa && mesa_is_new; }; then
            complain "Mesa >= $MESA could not be installed: SAPIEN will not draw; \`wmspec doctor\` says more"
        fi
    fi
}

set_up_browser() {
    if have chromium || have chromium-browser || have google-chrome; then return; fi
    say "installing Chromium, for the tests of the gallery"
    apt_install chromium || complain "without Chromium the tests of the gallery are skipped"
}

# ---------------------------------------------------------------- Python

python_is_good() { "$1" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; }

# 3.11 first: it is the newest for which every engine has a wheel.
find_python() {
    local python
    for python in ${PYTHON:-python3.11 python3.12 python3.13 python3.14 python3}; do
        if python_is_good "$python"; then
            "$python" -c 'import sys; print(sys.executable)'
            return
        fi
    done
    return 1
}

set_up_venv() {
    local python
    if "$VENV/bin/python" -c 'import sys, pip; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then return; fi
    if ! python=$(find_python); then
        apt_install python3 python3-venv || true
        python=$(find_python) || { complain "no Python >= 3.11 with venv; try \`make setup PYTHON=...\`"; exit 1; }
    fi
    say "making $VENV with $("$python" --version)"
    "$python" -m venv --clear "$VENV"
}

# pip's own words go to a log, in which the failure is found.
pip_install() { "$VENV/bin/python" -m pip install --quiet --disable-pip-version-check "$@" 2>>"$LOG"; }

# uv takes a fifth of pip's time; where it fails, pip tries.
install_packages() { "$VENV/bin/python" tools/install.py "$@" 2>>"$LOG" || pip_install "$@"; }

# PyBullet has wheels for few Pythons. It is compiled with NumPy in sight, or its pictures come back as tuples, which
# takes longer; GCC 14 takes its pointers for errors where older compilers warn.
compile_pybullet() {
    local headers
    headers=$("$VENV/bin/python" -c 'import sysconfig; print(sysconfig.get_path("include"))')
    if ! have g++ || [[ ! -e $headers/Python.h ]]; then apt_install g++ python3-dev || return 1; fi
    say "compiling PyBullet: some minutes"
    pip_install 'setuptools>=70.1' numpy &&
        CFLAGS=-Wno-incompatible-pointer-types pip_install --no-build-isolation -e '.[pybullet]'
}

install_engine() {
    install_packages --only-binary=pybullet -e ".[$1]" || { [[ $1 == pybullet ]] && compile_pybullet; }
}

set_up_packages() {
    local engine missing=()
    say "installing wmspec and its engines"
    : >"$LOG"
    if ! install_packages --only-binary=pybullet -e '.[engines,dev]' -e ./conformance; then
        install_packages -e '.[dev]' -e ./conformance || { tail -5 "$LOG" >&2; complain "wmspec could not be installed; more in $LOG"; exit 1; }
        for engine in "${ENGINES[@]}"; do install_engine "$engine" || missing+=("$engine"); done
    fi
    if ((${#missing[@]})); then
        complain "left out: ${missing[*]}; why is in $LOG; the rest works without; to try again: rm $STAMP"
    fi
}

fingerprint() { { cat pyproject.toml conformance/pyproject.toml tools/setup.sh; "$VENV/bin/python" --version; pwd; } 2>/dev/null | cksum; }

main() {
    if [[ ${1:-} == --browser ]]; then
        set_up_browser
        return
    fi
    set_up_system
    if [[ ${1:-} == --system ]]; then
        find_python >/dev/null || apt_install python3 python3-venv
        return
    fi
    if [[ -e $STAMP && $(cat "$STAMP") == "$(fingerprint)" && -x $VENV/bin/wmspec ]]; then return; fi
    set_up_venv
    set_up_packages
    fingerprint >"$STAMP"
    say "ready: $VENV/bin/wmspec"
}

main "$@"
