#!/usr/bin/env bash
# Makes the project's virtual environment and prints the path of its Python on standard output.
#
# PYTHON=python3.13, python3.11 or a path chooses the interpreter; otherwise 3.13 is looked for, then 3.11.
# The environment is .venv, or .venv-X.Y when .venv belongs to the other version. Needs neither root nor Blender.
# With --which, only prints the interpreter that would be used.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
versions="3.13 3.11" # in order of preference: Blender 5.2 LTS, Blender 4.5 LTS
without_venv=""      # interpreters that run but cannot make an environment

say() { echo "setup: $*" >&2; }
fail() {
    say "error: $1"
    shift
    for line in "$@"; do say "  $line"; done
    exit 1
}

# X.Y of an interpreter, found by running it: a version manager's stand-in may exist and fail.
version_of() {
    "$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null </dev/null
}

# Every place where Python X.Y may live, one a line, best guess first.
candidates() {
    local name="python$1"
    type -aP "$name" || true
    ls -1d "${PYENV_ROOT:-$HOME/.pyenv}/versions/$1"*/bin/"$name" 2>/dev/null | sort -rV || true
    if command -v uv >/dev/null; then uv python find --no-project "$1" 2>/dev/null || true; fi
    printf '%s\n' "/usr/local/bin/$name" "/usr/bin/$name" "/opt/homebrew/bin/$name"
    type -aP python3 python || true
}

# Prints the first interpreter that is Python X.Y and can make environments, else "!" and those that run but cannot.
find_version() {
    local path lame=""
    while IFS= read -r path; do
        [ "$(version_of "$path")" = "$1" ] || continue
        if "$path" -c 'import venv, ensurepip' 2>/dev/null </dev/null; then
            echo "$path"
            return
        fi
        lame="$lame $path"
    done < <(candidates "$1")
    echo "!$lame"
}

explain_nothing_found() { # $1: what was looked for, $2: interpreters without venv
    if [ -n "$2" ]; then
        fail "the venv module is missing from:$2" \
            "On Debian and Ubuntu: apt-get install python$1-venv" \
            "or name another interpreter: make test PYTHON=/path/to/python$1"
    fi
    fail "no working Python $1 was found" \
        "Looked in PATH, pyenv, uv, /usr/local/bin and /usr/bin, and ran what was there." \
        "Install Python 3.13 (for Blender 5.2) or 3.11 (for Blender 4.5), for instance with" \
        "'pyenv install 3.13' or 'uv python install 3.13', or name one: make test PYTHON=/path/to/python3.13"
}

# Sets $interpreter and $version.
choose_interpreter() {
    local wanted="" candidate lame=""
    if [ -n "${PYTHON:-}" ]; then
        if version="$(version_of "$PYTHON")"; then
            [[ " $versions " == *" $version "* ]] || fail "PYTHON=$PYTHON is Python $version" \
                "Blender's bpy module exists for Python 3.13 (Blender 5.2) and 3.11 (Blender 4.5)."
            if "$PYTHON" -c 'import venv, ensurepip' 2>/dev/null </dev/null; then
                interpreter="$PYTHON"
                return
            fi
            lame=" $PYTHON"
            wanted="$version"
            [[ "$PYTHON" != */* ]] || explain_nothing_found "$wanted" "$lame" # a path means that one and no other
        elif [[ "$PYTHON" =~ ^python(3\.[0-9]+)$ ]]; then
            wanted="${BASH_REMATCH[1]}"
            [[ " $versions " == *" $wanted "* ]] || fail "PYTHON=$PYTHON is not supported" "choose python3.13 or python3.11"
        else
            fail "PYTHON=$PYTHON does not run" "choose python3.13, python3.11 or the path of such an interpreter"
        fi
    fi
    for version in ${wanted:-$versions}; do
        candidate="$(find_version "$version")"
        if [[ "$candidate" != "!"* ]]; then
            interpreter="$candidate"
            return
        fi
        lame="$lame${candidate#!}"
    done
    explain_nothing_found "${wanted:-3.13}" "$lame"
}

# Sets $venv: .venv, unless it belongs to the other version.
choose_folder() {
    local found
    venv="$root/.venv"
    if found="$(version_of "$venv/bin/python")" && [ "$found" != "$version" ]; then
        venv="$root/.venv-$version"
    fi
    if [ -e "$venv" ] && [ "$(version_of "$venv/bin/python")" != "$version" ]; then
        say "$venv does not run any more: making it anew"
        rm -rf "$venv"
    fi
}

install() {
    local stamp="$venv/.requirements" wanted
    wanted="$(cat "$root"/requirements.txt "$root"/requirements-dev.txt "$root"/constraints.txt)"
    if [ -f "$stamp" ] && [ "$(cat "$stamp")" = "$wanted" ]; then return; fi
    if [ ! -x "$venv/bin/python" ]; then
        say "making $venv with $interpreter (Python $version)"
        "$interpreter" -m venv "$venv" >&2 || { rm -rf "$venv"; fail "$interpreter could not make $venv"; }
    fi
    say "installing the pinned requirements (about 1 GB on disk the first time)"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --only-binary=:all: \
        -r "$root/requirements-dev.txt" >&2 || fail "pip could not install requirements-dev.txt (see above)" \
        "The wheels need Linux x86-64 with glibc 2.28 or newer, Windows x86-64 or macOS on Apple silicon, and about 1 GB of disk."
    check_bpy
    printf '%s\n' "$wanted" >"$stamp"
}

# Blender's module is linked against a few desktop libraries that a bare server may lack.
check_bpy() {
    local problem
    if problem="$("$venv/bin/python" -c 'import os, bpy; os._exit(0)' 2>&1 </dev/null)"; then return; fi
    fail "bpy, Blender as a Python module, cannot be loaded: ${problem##*$'\n'}" \
        "It needs X11 and OpenGL libraries (no display). On Debian and Ubuntu:" \
        "apt-get install libx11-6 libxrender1 libxfixes3 libxi6 libxkbcommon0 libsm6 libice6 libgl1 libegl1"
}

choose_interpreter
if [ "${1:-}" = --which ]; then
    echo "$interpreter"
    exit
fi
exec 9<"$root"
if command -v flock >/dev/null; then flock 9; fi # two makes at once: one installs, the other waits
choose_folder
install
echo "$venv/bin/python"
