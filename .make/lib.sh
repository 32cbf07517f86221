# What the other scripts here share; make starts them in the root of the repository.

# Keep packages from elsewhere out of .venv; ROS sets this variable for every user.
unset PYTHONPATH
# Containers often forbid storing bytecode; tests start the server a hundred times, and without it
# each start takes two seconds longer.
unset PYTHONDONTWRITEBYTECODE

say() { printf 'wax: %s\n' "$*" >&2; }

die() {
    say "$*"
    exit 1
}

in_ci() {
    case ${CI:-} in 1 | true | yes) return 0 ;; *) return 1 ;; esac
}

# True if apt may install without asking.
may_apt() {
    command -v apt-get >/dev/null && { [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null; }
}

# One apt-get call that never waits for input or a hanging mirror.
_apt() {
    limit_s=$1
    shift
    if [ "$(id -u)" = 0 ]; then as_root=; else as_root="sudo -n"; fi
    $as_root timeout "$limit_s" env DEBIAN_FRONTEND=noninteractive apt-get -qq -y \
        -o Acquire::Retries=3 -o Acquire::http::Timeout=30 -o Acquire::https::Timeout=30 \
        -o DPkg::Lock::Timeout=120 "$@" </dev/null >>.cache/apt.log 2>&1
}

# Whether packages of exactly these names exist; on Ubuntu some names only refer to a snap.
_apt_has() {
    for package in "$@"; do
        apt-cache show "$package" 2>/dev/null | grep -qx "Package: $package" ||
            { echo "E: this system has no package $package" >>.cache/apt.log && return 1; }
    done
}

# Install Debian packages where that is allowed; the log stays in .cache/apt.log. Only the download
# has a short time limit, since unpacking must not be interrupted.
apt_install() {
    may_apt || return 1
    say "installing $* (apt)"
    mkdir -p .cache
    : >.cache/apt.log
    for _ in 1 2 3; do
        _apt 300 update && ! _apt_has "$@" && break
        _apt 900 install --no-install-recommends --download-only "$@" || continue
        _apt 3600 install --no-install-recommends "$@" && return 0
    done
    say "apt could not install $*: $(grep '^E:' .cache/apt.log | tail -n 1)"
    return 1
}

# A checksum of the given files and their paths.
checksum() { { pwd -P && cat "$@"; } | cksum; }

# uv with .venv's Python and without the project's settings, which are for `make lock`. uv itself
# allows a mirror 30 s and three retries. It ignores pip's settings, so pip's mirror is passed on.
uv() {
    UV_DEFAULT_INDEX=${UV_DEFAULT_INDEX:-$(_pip_index)} UV_SYSTEM_CERTS=${UV_SYSTEM_CERTS:-1} \
        .venv/bin/uv --no-config "$@" --python .venv/bin/python
}

_pip_index() {
    found=$(.venv/bin/python -m pip config list 2>/dev/null | sed -n "s/^.*\.index-url='\(.*\)'$/\1/p" | head -n 1)
    echo "${found:-https://pypi.org/simple}"
}

# usage: patiently SECONDS COMMAND…   runs a command that uses a mirror, up to three times, each with
# a time limit if the system has timeout(1), which macOS lacks.
patiently() {
    limit_s=$1
    shift
    bounded=
    ! command -v timeout >/dev/null || bounded="timeout --foreground -k 10 $limit_s"
    for pause_s in 2 4 0; do
        # shellcheck disable=SC2086  # words
        $bounded "$@" && return
        [ $pause_s = 0 ] || { say "failed: $1 …; trying again" && sleep $pause_s; }
    done
    return 1
}
