# Run a suite that measures, or tests the tests, after installing what it drives.
# usage: suite.sh bench | faults | public | cluster | voice | page | drivers | gallery | lab | soak | fuzz | mutants | coverage   ARGUMENTS…
set -eu
. .make/lib.sh
. .make/browsers.sh
PATH=$PWD/.venv/bin:$PATH
PYTHON=$PWD/.venv/bin/python
export PATH PYTHON

suite=$1
shift
case $suite in
bench) want_playwright && want_chromium && want_janus ;;
faults)
    want_playwright && want_chromium
    sh .make/firmware.sh board >/dev/null
    ;;
soak) ;;
public) sh .make/firmware.sh board >/dev/null ;;
cluster)
    want_playwright && want_chromium && want_ear && want_redis
    sh .make/firmware.sh board >/dev/null
    sh .make/livekit.sh
    ;;
lab)
    want_all && sh .make/livekit.sh
    uv pip install -q --require-hashes -r .make/speech.lock ||
        say "ViSQOL could not be built, see above; the voice has no score"
    ;;
voice) want_playwright && want_chromium && want_ear ;;
page)
    want_playwright && want_chromium && want_link && want_ear
    sh .make/firmware.sh board >/dev/null
    ;;
drivers)
    want_playwright && want_chromium && want_fastdds
    ;;
gallery)
    want_playwright && want_chromium
    sh .make/firmware.sh board >/dev/null
    ;;
mutants)
    sh .make/firmware.sh library >/dev/null # there is a compiler, or a sentence about it
    exec python -m tests.mutants "$@"
    ;;
fuzz)
    sh .make/firmware.sh library >/dev/null
    uv pip install -q --require-hashes -r .make/fuzz.lock ||
        say "atheris could not be installed, see above"
    exec python -m tests.fuzz "$@"
    ;;
coverage)
    status=0
    python -m tests.mutants.branches || status=1
    npm run --silent --prefix web coverage || status=1
    exit $status
    ;;
*) die "usage: suite.sh bench | faults | public | cluster | voice | page | drivers | gallery | lab | soak | fuzz | mutants | coverage ARGUMENTS…" ;;
esac
case $suite in
bench) suite=load ;;
cluster | page) suite=load.$suite ;;
faults) suite=stop ;;
drivers) suite=stop.$suite ;;
public) suite=strangers ;;
soak) suite=strangers.$suite ;;
lab) suite=delay ;;
voice) suite=delay.$suite ;;
esac
exec python -m "e2e.$suite" "$@"
