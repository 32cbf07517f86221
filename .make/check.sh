# Lint, format and strict types of both languages; all of them run, and one failure fails.
set -u
. .make/lib.sh
PATH=$PWD/.venv/bin:$PATH
PYTHON=$PWD/.venv/bin/python
export PATH PYTHON

status=0
step() { "$@" || { status=1 && say "failed: $*"; }; }

step ruff check .
step ruff format --check .
step mypy
step npm run --silent --prefix web check
exit $status
