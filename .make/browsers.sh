# Find the browsers and other programs that the tests use, or install what is missing where that is
# allowed.

# The first of the named programs that starts. Snaps are left out: they cannot see the profile
# that the tests make for them, and on Ubuntu the packages named like browsers only fetch snaps.
_browser() {
    for name in "$@"; do
        path=$(command -v "$name") || continue
        case $path in /snap/*) continue ;; esac
        head -c 4096 "$path" | grep -q /snap/ && continue
        "$path" --version >/dev/null 2>&1 || continue
        echo "$path"
        return
    done
    return 1
}

_chromium() {
    _browser chromium chromium-browser google-chrome google-chrome-stable \
        "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome" \
        "/Applications/Chromium.app/Contents/MacOS/Chromium"
}

_firefox() {
    _browser firefox-esr firefox /Applications/Firefox.app/Contents/MacOS/firefox
}

# If there is no package, Playwright installs a build of its own into the home directory.
_playwright_chromium() {
    if may_apt; then deps=--with-deps; else deps=; fi
    say "fetching Chromium by Playwright; its log is .cache/playwright.log"
    mkdir -p .cache
    patiently 1800 .venv/bin/playwright install $deps chromium >.cache/playwright.log 2>&1 || return 1
    _browser "$(.venv/bin/python -c 'from playwright.sync_api import sync_playwright
with sync_playwright() as playwright: print(playwright.chromium.executable_path)')"
}

# Without a browser its tests are skipped with a message; CI skips nothing.
_missing() {
    if in_ci; then die "$*"; else say "$*"; fi
}

# Playwright's own Node needs a library that a bare Debian lacks.
want_playwright() {
    .venv/bin/playwright --version >/dev/null 2>&1 ||
        { apt_install libatomic1 && .venv/bin/playwright --version >/dev/null 2>&1; } ||
        _missing "Playwright, which drives the browser of the tests, does not start;" \
            "type: .venv/bin/playwright --version (Debian: sudo apt-get install -y libatomic1)"
}

want_chromium() {
    [ -n "${WAX_CHROMIUM:-}" ] || WAX_CHROMIUM=$(_chromium) ||
        { apt_install chromium && WAX_CHROMIUM=$(_chromium); } ||
        WAX_CHROMIUM=$(_playwright_chromium) ||
        _missing "the tests in a browser cannot run: install Chromium" \
            "(Debian: sudo apt-get install -y chromium; Ubuntu: Google Chrome) or set WAX_CHROMIUM to its path"
    [ -z "${WAX_CHROMIUM:-}" ] || export WAX_CHROMIUM
}

want_firefox() {
    [ -n "${WAX_FIREFOX:-}" ] || WAX_FIREFOX=$(_firefox) ||
        { apt_install firefox-esr && WAX_FIREFOX=$(_firefox); } ||
        _missing "the smoke test in Firefox cannot run: install Firefox, not as a snap" \
            "(Debian: sudo apt-get install -y firefox-esr; Ubuntu: Mozilla's package) or set WAX_FIREFOX to its path"
    [ -z "${WAX_FIREFOX:-}" ] || export WAX_FIREFOX
}

# Only `make test-all` uses WebKitGTK. It needs a screen, which Xvfb keeps in memory.
want_webkit() {
    [ "$(uname)" = Linux ] || return 0
    { command -v WebKitWebDriver && command -v Xvfb; } >/dev/null ||
        apt_install webkit2gtk-driver xvfb ||
        _missing "the test in WebKitGTK cannot run: sudo apt-get install -y webkit2gtk-driver xvfb"
}

# The emulated link connects network namespaces, which only Linux has.
want_link() {
    [ "$(uname)" = Linux ] || return 0
    command -v ip >/dev/null || apt_install iproute2 ||
        _missing "the emulated link cannot be tested; type: sudo apt-get install -y iproute2"
}

# The measured speech is synthetic; without a voice, its cases report that they did not run.
want_voice() {
    [ "$(uname)" = Linux ] || return 0
    command -v espeak-ng >/dev/null || apt_install espeak-ng ||
        _missing "speech cannot be measured without a voice; install espeak-ng" \
            "(Debian: sudo apt-get install -y espeak-ng)"
}

# What a browser plays is recorded from a sound device; PulseAudio makes one without a sound card.
want_ear() {
    [ "$(uname)" = Linux ] || return 0
    { command -v pulseaudio && command -v parec; } >/dev/null ||
        apt_install pulseaudio pulseaudio-utils ||
        _missing "the sound cannot be recorded; type: sudo apt-get install -y pulseaudio pulseaudio-utils"
}

# Viewers whose network lets no UDP out reach the robot through a TURN server.
want_relay() {
    [ "$(uname)" = Linux ] || return 0
    { command -v turnserver && command -v nft; } >/dev/null || apt_install coturn nftables ||
        _missing "the relay cannot be tested; type: sudo apt-get install -y coturn nftables"
}

# The far end of the ssh tunnel also runs sshd and Caddy.
want_door() {
    [ "$(uname)" = Linux ] || return 0
    { command -v caddy && [ -x /usr/sbin/sshd ]; } >/dev/null || apt_install caddy openssh-server ||
        _missing "the door cannot be tested; type: sudo apt-get install -y caddy openssh-server"
}

# The MQTT broker, which Debian installs where only root's PATH leads.
want_broker() {
    [ "$(uname)" = Linux ] || return 0
    [ -x /usr/sbin/mosquitto ] || command -v mosquitto >/dev/null || apt_install mosquitto ||
        _missing "home automation cannot be tested; type: sudo apt-get install -y mosquitto"
}

# Another implementation of DDS, against which the driver for ROS 2 is tested; 3 MB.
want_fastdds() {
    [ "$(uname)" = Linux ] || return 0
    [ -d /usr/include/fastdds ] || apt_install libfastrtps-dev || apt_install libfastdds-dev ||
        _missing "the driver for ROS 2 cannot be tested against Fast DDS;" \
            "type: sudo apt-get install -y libfastrtps-dev"
}

# Janus, with which a viewer's cost is compared; without it that column stays empty.
want_janus() {
    [ "$(uname)" = Linux ] || return 0
    command -v janus >/dev/null || apt_install janus ||
        say "nothing can be compared with Janus; type: sudo apt-get install -y janus"
}

# LiveKit's nodes find each other through Redis.
want_redis() {
    [ "$(uname)" = Linux ] || return 0
    command -v redis-server >/dev/null || apt_install redis-server ||
        _missing "the cluster cannot be tested; type: sudo apt-get install -y redis-server"
}

# Everything that both tests and measurements need.
want_all() {
    want_playwright
    want_chromium
    want_firefox
    want_link
    want_voice
    want_ear
    want_relay
    want_broker
}
