# What measures, or tests the tests: see that what it drives is there, then run it.
# usage: suite.sh bench | faults | lab | mutants | coverage   ARGUMENTS…
set -eu
. .make/lib.sh
. .make/browsers.sh
PATH=$PWD/.venv/bin:$PATH
PYTHON=$PWD/.venv/bin/python
export PATH PYTHON

# 100,000 traces of each kind take some minutes.
traces() {
    WAX_TRACES=100000 WAX_STEPS=100000 pytest -q tests/control/test_black_channel.py \
        tests/control/test_hand_over.py \
        tests/firmware/test_line_black_channel.py::test_no_wrong_execution >&2
}

suite=$1
shift
case $suite in
bench) want_playwright && want_chromium ;;
faults)
    want_playwright && want_chromium
    sh .make/firmware.sh board >/dev/null
    [ $# != 0 ] || traces
    ;;
lab) want_all && sh .make/livekit.sh ;;
mutants) sh .make/firmware.sh library >/dev/null ;; # there is a compiler, or a sentence about it
coverage)
    status=0
    python -m e2e.mutants.branches || status=1
    npm run --silent --prefix web coverage || status=1
    exit $status
    ;;
*) die "usage: suite.sh bench | faults | lab | mutants | coverage ARGUMENTS…" ;;
esac
exec python -m "e2e.$suite" "$@"
