#include <string.h>

#include "bench.h"
#include "finding.h"

namespace port_test {

// --- the clock ---

// Read the clock all the time; `load` comes over the line meanwhile.
static Finding watch_clock(uint32_t for_us, bool load) {
    static uint8_t noise[32];
    const uint32_t began_us = bench::now_us(), began_ms = port::now_ms();
    uint32_t last_ms = began_ms, loaded_us = began_us;
    while (since(began_us) < for_us) {
        port::feed_watchdog();
        const uint32_t now_ms = port::now_ms();
        const uint32_t step_ms = now_ms - last_ms;
        if (step_ms > UINT32_MAX / 2) return "it went back";
        if (step_ms > port::CLOCK_STEP_MS)
            return wrong("it stepped by ms", static_cast<int32_t>(step_ms), port::CLOCK_STEP_MS);
        last_ms = now_ms;
        if (load && since(loaded_us) >= 4 * MS) {
            loaded_us = bench::now_us();
            bench::send(noise, sizeof noise);
        }
        bench::wait_us(100);
    }
    const int32_t passed_ms = static_cast<int32_t>(since(began_us) / MS);
    const int32_t told_ms = static_cast<int32_t>(last_ms - began_ms);
    if (distance(passed_ms, told_ms) > passed_ms * port::CLOCK_ERROR_PERCENT / 100 + 1)
        return wrong("it counted ms", told_ms, passed_ms);
    return nullptr;
}

Finding clock_goes_on() { return watch_clock(2000 * MS, false); }

Finding clock_goes_on_under_load() {
    if (!bench::turn(2000, -2000, port::TICKS_PER_S)) return NOT_TESTED;
    const Finding found = watch_clock(400 * MS, true);
    drain();
    return found;
}

Finding noise_differs() {
    uint32_t seen[16];
    uint8_t alike = 0;
    for (uint8_t at = 0; at < 16; ++at) {
        seen[at] = port::noise();
        port::feed_watchdog();
        for (uint8_t before = 0; before < at; ++before)
            if (seen[before] == seen[at]) ++alike;
    }
    return alike > 1 ? wrong("of 16 numbers were alike", alike, 0) : nullptr;
}

// --- no function waits ---

Finding nothing_waits() {
    uint8_t byte;
    const uint8_t report[wax::REPORT_SIZE] = {};
    for (uint8_t round = 0; round < 20; ++round) {
        for (uint8_t which = 0; which < 9; ++which) {
            const uint32_t began_us = bench::now_us();
            switch (which) {
                case 0: port::now_ms(); break;
                case 1: port::read(byte); break;
                case 2: if (port::room() >= sizeof report) port::write(report, sizeof report); break;
                case 3: port::motor(port::LEFT, 0); break;
                case 4: port::servo(0, 0); break;
                case 5: port::battery(); break;
                case 6: port::bumpers(); break;
                case 7: port::ticks(port::LEFT); break;
                default: port::feed_watchdog();
            }
            if (since(began_us) > port::CALL_US)
                return wrong("a call took us", static_cast<int32_t>(since(began_us)),
                             port::CALL_US);
        }
        pass(2 * MS);
    }
    drain();
    return nullptr;
}

// --- the serial line ---

Finding bytes_are_kept_in_order() {
    uint8_t bytes[port::RECEIVES_AT_LEAST], byte;
    for (uint8_t at = 0; at < sizeof bytes; ++at) bytes[at] = static_cast<uint8_t>(at * 37 + 1);
    for (uint8_t round = 0; round < 5; ++round) {
        if (!bench::send(bytes, sizeof bytes)) return NOT_TESTED;
        pass(20 * MS);
        for (uint8_t at = 0; at < sizeof bytes; ++at) {
            if (!port::read(byte)) return wrong("bytes were kept", at, sizeof bytes);
            if (byte != bytes[at]) return wrong("a byte was", byte, bytes[at]);
        }
        if (port::read(byte)) return "it read a byte that nobody sent";
    }
    return nullptr;
}

Finding reports_are_sent_whole() {
    uint8_t report[wax::REPORT_SIZE], seen[2 * wax::REPORT_SIZE];
    for (uint8_t round = 0; round < 20; ++round) {
        for (uint8_t at = 0; at < sizeof report; ++at) report[at] = static_cast<uint8_t>(at + round);
        pass(port::REPORT_SENT_MS * MS);
        if (port::room() < sizeof report) return wrong("bytes had room", port::room(), sizeof report);
        port::write(report, sizeof report);
        pass(port::REPORT_SENT_MS * MS);
        const int32_t count = bench::sent(seen, sizeof seen);
        if (count == bench::CANNOT) return NOT_TESTED;
        if (count != sizeof report) return wrong("bytes were sent", count, sizeof report);
        if (memcmp(seen, report, sizeof report) != 0) return "other bytes were sent";
    }
    return nullptr;
}

}  // namespace port_test
