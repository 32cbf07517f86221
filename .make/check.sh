# Lint, format, strict types and import rules; all run, even after one has failed.
set -u
. .make/lib.sh
PATH=$PWD/.venv/bin:$PATH
PYTHON=$PWD/.venv/bin/python
export PATH PYTHON

status=0
step() { "$@" || { status=1 && say "failed: $*"; }; }

# The page's checks run at the same time as Python's, on another core.
mkdir -p .cache
npm run --silent --prefix web check >.cache/check-page.log 2>&1 &
page=$!
step ruff check .
step ruff format --check .
step mypy
step sh -c 'python -m wax.config | diff config/wax.toml -' # make manual
step lint-imports --no-logo --cache-dir .cache/imports
wait $page || { status=1 && say "failed: npm run check"; }
cat .cache/check-page.log
exit $status
