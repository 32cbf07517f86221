# Install Lighthouse, which judges the page in `make test-all`, into .cache/lighthouse, by the lock
# beside this file. Nothing fails without it: its test then says that it did not run.
set -eu
. .make/lib.sh

from=.make/lighthouse
folder=.cache/lighthouse
log=.cache/lighthouse.log

wanted=$(checksum $from/package.json $from/package-lock.json)
[ "$(cat $folder/.wax 2>/dev/null)" != "$wanted" ] || exit 0
PATH=$PWD/.venv/bin:$PATH # where Node is, if this machine had none
mkdir -p $folder
cp $from/package.json $from/package-lock.json $folder/
say "installing Lighthouse (once, a minute); its log is $log"
patiently 600 npm ci --prefix $folder --ignore-scripts --no-audit --no-fund --loglevel error \
    >"$log" 2>&1 || {
    say "Lighthouse could not be installed, see $log"
    exit 0
}
echo "$wanted" >$folder/.wax
