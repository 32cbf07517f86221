# Build LiveKit, with which WAX is compared, into .cache/livekit. Nothing fails without it: its
# column then says that it was not run, and why.
# This is the newest version that `go install` accepts; later ones have `replace` lines in their go.mod.
set -eu
. .make/lib.sh

version=1.11.0
package=github.com/livekit/livekit-server/cmd/server@v$version
folder=$PWD/.cache/livekit
log=.cache/livekit.log

# usage: without REASON…
without() {
    say "it is measured without LiveKit: $*"
    exit 0
}

is_there() { "$folder/server" --version 2>/dev/null | grep -qwF "$version"; }

last_words() {
    words=$(grep -v '^wax: ' "$log" | tail -n 1)
    echo "${words:-no answer}"
}

[ -z "${WAX_LIVEKIT:-}" ] || exit 0
! is_there || exit 0
command -v go >/dev/null ||
    without "there is no Go; install it (https://go.dev/dl), or set WAX_LIVEKIT to the path of" \
        "livekit-server $version"

mkdir -p .cache
# A mirror that does not answer must not cost as much time as a build may take.
patiently 60 go list -m "${package%%/cmd/*}@v$version" >"$log" 2>&1 ||
    without "Go does not get the module ($(last_words)); type make again when its mirror answers"
say "building LiveKit $version with Go (once, a minute or two); its log is $log"
patiently 1800 env GOBIN="$folder" go install "$package" >"$log" 2>&1 ||
    without "Go could not build it ($(last_words))"
is_there || without "what Go built at $folder/server does not start"
