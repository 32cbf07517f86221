# All checks and tests of both languages, pytest last so that its summary closes the output.
set -eu
. .make/lib.sh

sh .make/install.sh check
python=.venv/bin/python
. .make/browsers.sh
want_all
sh .make/firmware.sh board >/dev/null

PATH=$PWD/.venv/bin:$PATH
PYTHON=$PWD/.venv/bin/python
export PATH PYTHON

status=0
sh .make/check.sh || status=1
sh .make/install.sh test
npm run --silent --prefix web test || { status=1 && say "failed: the page's tests"; }

# Where no link can be made the lab says why and ends with 77; only CI insists.
lab=0
rm -rf e2e/out/quick
python -m e2e.lab --quick --out e2e/out/quick || lab=$?
case $lab in
0) ;;
77) ! in_ci || { status=1 && say "failed: the quick lab, which CI requires"; } ;;
130) exit 130 ;;
*) status=1 && say "failed: the quick lab" ;;
esac
[ $status = 0 ] || say "checks, the page's tests or the lab failed, see above; the Python tests follow"

# Most unit tests compute or wait, so one half runs beside the other; a whole server has both cores.
first="tests/control tests/sync tests/firmware tests/media"
ignored=$(printf ' --ignore=%s' $first)
mkdir -p .cache
# shellcheck disable=SC2086  # these are words
pytest -q $first >.cache/test-first.log 2>&1 &
beside=$!
# shellcheck disable=SC2086
pytest -q tests $ignored || status=1
wait $beside || status=1
cat .cache/test-first.log
pytest e2e || status=1
exit $status
