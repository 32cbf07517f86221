# All checks and tests of both languages, pytest last so that its summary closes the output.
set -eu
. .make/lib.sh

sh .make/install.sh check
python=.venv/bin/python
. .make/browsers.sh
want_playwright
want_chromium
want_firefox
want_link
sh .make/livekit.sh

PATH=$PWD/.venv/bin:$PATH
PYTHON=$PWD/.venv/bin/python
export PATH PYTHON

status=0
sh .make/check.sh || status=1
sh .make/install.sh test
npm run --silent --prefix web test || { status=1 && say "failed: the page's tests"; }
[ $status = 0 ] || say "the checks or the page's tests failed, see above; the Python tests follow"
pytest tests e2e || status=1
exit $status
