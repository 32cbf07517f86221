# Build the robot's firmware for this machine, or for the Arduino; all of it goes to
# .cache/firmware and is built again only when its source has changed.
#
#   board               wax-board, the core behind a pseudo-terminal; prints its path
#   library [SOURCE [FOLDER]]  the core as a shared library; prints its path. SOURCE replaces
#                       server/firmware, as by a copy with a fault in it, FOLDER the cache
#   coverage COMMAND…   run a command with WAX_FIRMWARE_LIBRARY set to a core that counts its
#                       branches; prints how many of them were taken
#   port                wax-port-test, which checks a port's promises on a fake board; prints its
#                       path
#   avr [SOURCE [FOLDER]]  the sketch for the ATmega328P of an Uno; prints its sizes as JSON
#   emulator            wax-emulated-uno, which runs such a sketch in simavr; prints its path
set -eu
. .make/lib.sh

firmware=server/firmware
cache=$PWD/.cache/firmware
warnings="-Wall -Wextra -Wconversion -Werror"

want_compiler() {
    ! command -v c++ >/dev/null || return 0
    apt_install g++ libc6-dev && command -v c++ >/dev/null && return 0
    die "the robot's firmware cannot be built for the tests: there is no C++ compiler; type:" \
        "sudo apt-get install -y g++ (macOS: xcode-select --install)"
}

# usage: is_built FILE KEY
is_built() { [ -e "$1" ] && [ "$(cat "$1.key" 2>/dev/null)" = "$2" ]; }

# The checksum of all sources below a folder, and of this script.
sources_of() {
    find "$1" -type f \( -name '*.h' -o -name '*.cpp' -o -name '*.ino' \) | LC_ALL=C sort |
        { xargs cat && cat .make/firmware.sh; } | cksum | tr ' ' -
}

# usage: build FILE KEY ARGUMENT…   (moved into place when complete: two tests may build at once)
build() {
    out=$1 key=$2
    shift 2
    is_built "$out" "$key" && return
    want_compiler
    mkdir -p "$cache"
    # shellcheck disable=SC2086
    c++ -std=c++11 -O2 $warnings "$@" -o "$out.$$" && mv "$out.$$" "$out" && echo "$key" >"$out.key"
}

board() {
    build "$cache/wax-board" "$(sources_of $firmware)" \
        $firmware/wax/src/core/*.cpp $firmware/host/board.cpp $firmware/host/main.cpp \
        $firmware/host/pty.cpp
    echo "$cache/wax-board"
}

library() {
    build "$2/libwax.so" "$(sources_of "$1")" -shared -fPIC "$1"/wax/src/core/*.cpp \
        "$1/host/capi.cpp"
    echo "$2/libwax.so"
}

port() {
    build "$cache/wax-port-test" "$(sources_of $firmware)" \
        $firmware/wax/src/*.cpp $firmware/wax/src/core/*.cpp $firmware/port_test/*.cpp \
        $firmware/host/fake_board.cpp $firmware/host/port_test.cpp
    echo "$cache/wax-port-test"
}

coverage() {
    want_compiler
    folder=$cache/coverage
    rm -rf "$folder"
    mkdir -p "$folder"
    for source in $firmware/wax/src/core/*.cpp $firmware/host/capi.cpp; do
        # shellcheck disable=SC2086
        c++ -std=c++11 -O0 --coverage -fno-exceptions -fPIC $warnings -c "$source" \
            -o "$folder/$(basename "$source" .cpp).o"
    done
    c++ --coverage -shared "$folder"/*.o -o "$folder/libwax.so"
    WAX_FIRMWARE_LIBRARY=$folder/libwax.so "$@" >&2
    .venv/bin/gcovr --root . --filter "$firmware/wax/src/core/" --txt-metric branch --txt - \
        --fail-under-line 100 --fail-under-branch 100 "$folder"
}

avr() {
    core=/usr/share/arduino/hardware/arduino/avr
    { command -v avr-g++ >/dev/null && [ -d $core ]; } ||
        apt_install gcc-avr avr-libc arduino-core-avr ||
        die "the sketch cannot be compiled for the Arduino; type:" \
            "sudo apt-get install -y gcc-avr avr-libc arduino-core-avr"
    folder=$2
    key=$(sources_of "$1")
    if ! is_built "$folder/wax.elf" "$key"; then
        rm -rf "$folder"
        mkdir -p "$folder"
        common="-mmcu=atmega328p -DF_CPU=16000000L -DARDUINO=10819 -DARDUINO_AVR_UNO
            -DARDUINO_ARCH_AVR -DDECIMAL_DIG=__DECIMAL_DIG__ -Os -ffunction-sections -fdata-sections -fno-exceptions
            -I$core/cores/arduino -I$core/variants/standard"
        # shellcheck disable=SC2086
        {
            # Arduino's own code may have warnings.
            (cd "$folder" && avr-gcc $common -w -c $core/cores/arduino/*.c &&
                avr-g++ $common -w -std=gnu++11 -fno-threadsafe-statics -c $core/cores/arduino/*.cpp &&
                avr-gcc $common -w -x assembler-with-cpp -c $core/cores/arduino/*.S)
            # Arduino adds the first line itself.
            avr-g++ $common $warnings -std=gnu++11 -fno-threadsafe-statics -x c++ \
                -include Arduino.h -c "$1"/wax/wax.ino -o "$folder/sketch.o"
            for source in "$1"/wax/src/*.cpp "$1"/wax/src/core/*.cpp; do
                avr-g++ $common $warnings -std=gnu++11 -fno-threadsafe-statics -c "$source" \
                    -o "$folder/wax-$(basename "$source" .cpp).o"
            done
            avr-g++ -mmcu=atmega328p -Os -Wl,--gc-sections "$folder"/*.o -o "$folder/wax.elf"
        }
        echo "$key" >"$folder/wax.elf.key"
    fi
    avr-size -A "$folder/wax.elf" | awk '
        { size[$1] = $2 }
        END {
            printf "{\"flash_bytes\": %d, \"flash_bytes_of\": 32256, ", size[".text"] + size[".data"]
            printf "\"ram_bytes\": %d, \"ram_bytes_of\": 2048}\n", size[".data"] + size[".bss"]
        }'
}

emulator() {
    [ -e /usr/include/simavr/sim_avr.h ] || apt_install libsimavr-dev ||
        die "there is no emulator of the Arduino; type: sudo apt-get install -y libsimavr-dev"
    build "$cache/wax-emulated-uno" "$(sources_of $firmware)" -isystem /usr/include/simavr \
        $firmware/host/emulated_uno.cpp $firmware/host/pty.cpp -lsimavr
    echo "$cache/wax-emulated-uno"
}

what=${1:-board}
[ $# = 0 ] || shift
case $what in
board) board ;;
library) library "${1:-$firmware}" "${2:-$cache}" ;;
coverage) coverage "$@" ;;
port) port ;;
avr) avr "${1:-$firmware}" "${2:-$cache/avr}" ;;
emulator) emulator ;;
*)
    die "usage: sh .make/firmware.sh board | library [SOURCE [FOLDER]] | coverage COMMAND… | port |" \
        "avr [SOURCE [FOLDER]] | emulator"
    ;;
esac
