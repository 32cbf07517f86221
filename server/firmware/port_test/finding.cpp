#include "finding.h"

#include <stdio.h>

#include "bench.h"

namespace port_test {

const char NOT_TESTED[] = "";

Finding wrong(const char *what, int32_t found, int32_t wanted) {
    static char text[96];
    snprintf(text, sizeof text, "%s: %ld instead of %ld", what, static_cast<long>(found),
             static_cast<long>(wanted));
    return text;
}

int32_t distance(int32_t a, int32_t b) { return a < b ? b - a : a - b; }

uint32_t since(uint32_t began_us) { return bench::now_us() - began_us; }

// Let time pass for a program that lives.
void pass(uint32_t us) {
    for (const uint32_t began_us = bench::now_us(); since(began_us) < us;) {
        port::feed_watchdog();
        bench::wait_us(MS);
    }
}

void drain() {
    uint8_t byte;
    pass(10 * MS);
    for (uint16_t count = 0; count < 1000 && port::read(byte); ++count) port::feed_watchdog();
    uint8_t bytes[64];
    while (bench::sent(bytes, sizeof bytes) > 0) {
    }
}

Finding expect_motors(int16_t left, int16_t right, int16_t back_left, int16_t back_right) {
    const int16_t wanted[] = {left, right, back_left, back_right};
    const char *const names[] = {"power of the left motor", "power of the right motor",
                                 "power of the back left motor", "power of the back right motor"};
    for (uint8_t wheel = 0; wheel < wax::MAX_WHEELS; ++wheel) {
        const int32_t found = bench::motor(static_cast<port::Wheel>(wheel));
        if (found == bench::CANNOT) {
            if (wheel <= port::RIGHT) return NOT_TESTED;
            continue;
        }
        if (distance(found, wanted[wheel]) > 2) return wrong(names[wheel], found, wanted[wheel]);
    }
    return nullptr;
}

}  // namespace port_test
