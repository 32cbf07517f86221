# The tests of both languages, cheapest first, and pytest last so that its summary ends the output.
# Every stage runs, even after one has failed, and says how long it took.
# usage: test.sh unit | test | all
#   unit   pure code: no browser, no other process
#   test   the checks, unit, tests that start processes, the browsers
#   all    the same at full length, branch coverage, each kind of link, the tests of the suites
set -eu
. .make/lib.sh
what=$1

status=0
failed() { status=1 && say "failed: $*"; }

# usage: stage NAME COMMAND…
stage() {
    name=$1
    shift
    began_s=$(date +%s)
    say "$name …"
    "$@" || failed "$name"
    took_s=$(($(date +%s) - began_s))
    say "$name took $took_s s"
}

# usage: python_tests MARKERS ARGUMENTS…
python_tests() {
    markers=$1
    shift
    pytest -q -m "$markers" --hypothesis-profile="$profile" --durations=10 "$@"
}

# Both at once; Python's in four processes, since they also wait, and last, for their summary.
unit_tests() {
    npm run --silent --prefix web test >.cache/page-tests.log 2>&1 &
    page=$!
    failures=0
    python_tests "not system$short" tests -n 4 --dist worksteal || failures=1
    wait $page || { cat .cache/page-tests.log && failures=1; }
    return $failures
}

# A missed goal (1) is no failure: the question here is whether the suite works. If no link can be
# made, it says why and exits with 77; only CI treats that as a failure.
delay() {
    rm -rf e2e/out/quick
    code=0
    python -m e2e.measure delay --again --quick --out e2e/out/quick "$@" || code=$?
    [ $code != 130 ] || exit 130
    [ $code -le 1 ] || { [ $code = 77 ] && ! in_ci; }
}

if [ "$what" = unit ]; then sh .make/install.sh check; else sh .make/install.sh test; fi
sh .make/firmware.sh library >/dev/null # there is a compiler, or a sentence that says what to do
PATH=$PWD/.venv/bin:$PATH
PYTHON=$PWD/.venv/bin/python
export PATH PYTHON

if [ "$what" = all ]; then profile=full short=; else profile=quick short=" and not full"; fi
if [ "$what" != unit ]; then
    . .make/browsers.sh
    want_all
    sh .make/firmware.sh board >/dev/null
    [ "$what" = test ] || { want_redis && want_webkit && want_fastdds && want_door && sh .make/livekit.sh; }
    stage "checks" sh .make/check.sh
fi
stage "the unit tests of both languages" unit_tests
[ "$what" != unit ] || exit $status
# The files with tests of this marker: collecting all others takes longer than many of these tests.
marked() { grep -rl "mark\.$1" tests --include='test_*.py' | sort; }
# shellcheck disable=SC2046  # words
started() { python_tests "system and not alone$short" $(marked system) -n 4 --dist worksteal; }
# shellcheck disable=SC2046  # words
deadlines() { python_tests "system and alone$short" $(marked alone); }
stage "what starts processes" started
stage "the deadlines of processes and lines" deadlines
if [ "$what" = all ]; then
    stage "the branches" sh .make/suite.sh coverage
    stage "each kind of link, briefly" delay --only instrument "same-machine/*" wireless-1m/operator \
        modem-56k/thesis step-down/operator first-picture/internet-5m input/key mute
fi
[ $status = 0 ] || say "something failed, see above; the tests in browsers follow"
stage "the browsers" python_tests "not system$short" e2e
exit $status
