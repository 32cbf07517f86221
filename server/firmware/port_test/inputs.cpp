#include "bench.h"
#include "finding.h"

namespace port_test {

// --- what the board feels ---

Finding battery_is_in_proportion() {
    const int32_t full = port::battery_full_scale();
    if (full > port::BATTERY_FULL_SCALE_MOST)
        return wrong("full scale", full, port::BATTERY_FULL_SCALE_MOST);
    const uint16_t charges[] = {0, 250, 500, 900};
    for (const uint16_t charge : charges) {
        if (!bench::charge(charge)) return NOT_TESTED;
        pass(5 * MS);
        const int32_t found = port::battery(), wanted = full * charge / 1000;
        if (distance(found, wanted) > full * port::BATTERY_ERROR_PERCENT / 100)
            return wrong("the battery's number", found, wanted);
    }
    return nullptr;
}

Finding bumpers_are_felt() {
    const uint8_t all = bench::bumpers();
    for (uint8_t bits = 0; bits < 16; ++bits) {
        const uint8_t pressed = bits & all;
        if (!bench::press(pressed)) return NOT_TESTED;
        pass(30 * MS);
        if (port::bumpers() != pressed) return wrong("pressed bumpers", port::bumpers(), pressed);
    }
    bench::press(0);
    return nullptr;
}

static Finding turn_and_count(int32_t left, int32_t right) {
    static uint8_t noise[32];
    const int32_t began[] = {port::ticks(port::LEFT), port::ticks(port::RIGHT)};
    if (!bench::turn(left, right, port::TICKS_PER_S)) return NOT_TESTED;
    for (uint8_t round = 0; round < 100; ++round) {  // for longer than they turn
        bench::send(noise, sizeof noise);
        pass(5 * MS);
    }
    drain();
    const int32_t counted[] = {port::ticks(port::LEFT) - began[0],
                               port::ticks(port::RIGHT) - began[1]};
    if (distance(counted[0], left) > 1) return wrong("ticks of the left wheel", counted[0], left);
    if (distance(counted[1], right) > 1)
        return wrong("ticks of the right wheel", counted[1], right);
    return nullptr;
}

Finding ticks_are_counted() {
    const int32_t turns[][2] = {{2000, 2000}, {-2000, -1999}, {1500, -1500}, {0, 0}};
    for (const auto &turn : turns)
        if (const Finding found = turn_and_count(turn[0], turn[1])) return found;
    return nullptr;
}

// --- the watchdog ---

Finding a_living_program_is_left_alone() {
    const int32_t before = bench::restarts();
    if (before == bench::CANNOT) return NOT_TESTED;
    for (uint8_t round = 0; round < 100; ++round) {
        port::feed_watchdog();
        bench::wait_us(port::WATCHDOG_LEAST_MS * MS);
    }
    const int32_t count = bench::restarts() - before;
    return count ? wrong("restarts", count, 0) : nullptr;
}

Finding a_program_that_hangs_is_restarted() {
    bool motors_off = false;
    port::motor(port::LEFT, 200);
    port::motor(port::RIGHT, 200);
    port::motor(port::BACK_LEFT, 200);
    port::motor(port::BACK_RIGHT, 200);
    port::feed_watchdog();
    const int32_t took_us = bench::hang(2 * port::WATCHDOG_MOST_MS * MS, motors_off);
    if (took_us == bench::CANNOT) return NOT_TESTED;
    if (took_us > static_cast<int32_t>(port::WATCHDOG_MOST_MS * MS))
        return wrong("it restarted after us", took_us, port::WATCHDOG_MOST_MS * MS);
    return motors_off ? nullptr : "the motors had power after it";
}

}  // namespace port_test
