#!/bin/sh
# Chooses a Python for the workspace and hands over to scripts/workspace.py. Chosen is, in this order: $PYTHON if given, the one the
# existing .venv was made with, the first python3.12, python3.11 or python3 that runs, fits and is complete.
set -u
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd) || exit 1
venv_python=$here/../.venv/bin/python

version_fits='import sys
sys.exit(not ((3, 11) <= sys.version_info[:2] <= (3, 12) and sys.implementation.name == "cpython"))'
is_complete='import ensurepip, os, sys, sysconfig, venv
sys.exit(not os.path.isfile(os.path.join(sysconfig.get_path("include"), "Python.h")))'

find_python() {
    # A candidate is run, not only found: a pyenv shim exists for versions that are not active and fails when started.
    incomplete=
    for candidate in python3.12 python3.11 python3 python; do
        if "$candidate" -I -c "$version_fits" >/dev/null 2>&1; then
            if "$candidate" -I -c "$is_complete" >/dev/null 2>&1; then
                echo "$candidate"
                return
            fi
            incomplete=${incomplete:-$candidate}
        fi
    done
    # An incomplete one still serves: workspace.py says what it lacks.
    echo "$incomplete"
}

if [ -n "${PYTHON:-}" ]; then
    python=$PYTHON
    if ! "$python" -I -c '' >/dev/null 2>&1; then
        echo "setup: PYTHON=$python does not run; give a Python 3.11 or 3.12, e.g. make PYTHON=/usr/bin/python3.12 setup" >&2
        exit 1
    fi
else
    python=$("$venv_python" -I -S -c 'import sys; print(sys._base_executable)' 2>/dev/null) && [ -x "$python" ] || python=$(find_python)
    if [ -z "$python" ]; then
        found=$(python3 --version 2>/dev/null || echo none)
        echo "setup: needs Python 3.11 or 3.12 (python3 here: $found); install one, e.g. apt-get install python3.12 python3.12-venv python3.12-dev, or name it: make PYTHON=/path/to/python3.12 setup" >&2
        exit 1
    fi
fi
exec "$python" -I -S "$here/workspace.py" "$@"
