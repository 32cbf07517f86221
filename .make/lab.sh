# The lab: chapter 5 again, over shaped networks; a report is left in e2e/out/lab.
# usage: lab.sh [ARGUMENTS…]
set -eu
. .make/lib.sh
. .make/browsers.sh
want_all
sh .make/livekit.sh

PATH=$PWD/.venv/bin:$PATH
export PATH
exec python -m e2e.lab "$@"
