# Run a measurement, or a test of the tests, after installing the programs that it drives.
# usage: suite.sh measure | gallery | fuzz | mutants | coverage   ARGUMENTS…
set -eu
. .make/lib.sh
. .make/browsers.sh
PATH=$PWD/.venv/bin:$PATH
PYTHON=$PWD/.venv/bin/python
export PATH PYTHON

what=$1
shift

# Whether a suite is measured: the words name it, or no suite at all.
# usage: measures SUITE WORD…
measures() {
    suite=$1
    shift
    case " $* " in
    *" $suite "*) ;;
    *" delay "* | *" load "* | *" stop "* | *" strangers "* | *" safety-tests "*) return 1 ;;
    esac
}

want_fuzz() {
    sh .make/firmware.sh library >/dev/null
    uv pip install -q --require-hashes -r .make/fuzz.lock ||
        say "atheris could not be installed, see above"
}

# What the chosen suites drive. A case says if something that it needs is still missing.
want_suites() {
    want_playwright && want_chromium
    sh .make/firmware.sh board >/dev/null
    if measures delay "$@" || measures load "$@"; then
        want_all && want_janus && want_redis && sh .make/livekit.sh
    fi
    ! measures stop "$@" || want_fastdds
    ! measures strangers "$@" || { want_link && want_fuzz; }
    ! measures safety-tests "$@" || sh .make/firmware.sh library >/dev/null
}

case $what in
measure)
    case " $* " in
    *" --list "* | *" --changed "* | *" --render "* | *" --help "*) ;;
    *) want_suites "$@" ;;
    esac
    exec python -m e2e.measure "$@"
    ;;
gallery)
    want_playwright && want_chromium
    sh .make/firmware.sh board >/dev/null
    exec pytest -m full e2e/gallery/test_states.py::test_every_state_has_no_finding "$@"
    ;;
fuzz)
    want_fuzz
    [ $# -gt 0 ] || set -- "fuzz-*"
    exec python -m e2e.measure strangers --again --long --only "$@"
    ;;
mutants)
    sh .make/firmware.sh library >/dev/null # there is a compiler, or a sentence about it
    exec python -m tests.mutants "$@"
    ;;
coverage)
    status=0
    python -m tests.mutants.branches || status=1
    npm run --silent --prefix web coverage || status=1
    exit $status
    ;;
*) die "usage: suite.sh measure | gallery | fuzz | mutants | coverage ARGUMENTS…" ;;
esac
