#include "promises.h"

#include <stdio.h>
#include <string.h>

#include "../wax/src/core/crc16.h"
#include "../wax/src/core/frame.h"
#include "../wax/src/program.h"
#include "bench.h"

namespace port_test {

namespace {

const uint32_t MS = 1000;

// What is wrong, or nullptr.
typedef const char *Finding;
const char NOT_TESTED[] = "";

char text[96];

Finding wrong(const char *what, int32_t found, int32_t wanted) {
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

// --- the clock ---

// Read the clock all the time; `load` comes over the line meanwhile.
Finding watch_clock(uint32_t for_us, bool load) {
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

// --- the motors ---

Finding expect_motors(int16_t left, int16_t right) {
    const int32_t found[] = {bench::motor(port::LEFT), bench::motor(port::RIGHT)};
    if (found[0] == bench::CANNOT || found[1] == bench::CANNOT) return NOT_TESTED;
    if (distance(found[0], left) > 2) return wrong("power of the left motor", found[0], left);
    if (distance(found[1], right) > 2) return wrong("power of the right motor", found[1], right);
    return nullptr;
}

Finding motors_are_off_at_first() { return expect_motors(0, 0); }

Finding motors_follow() {
    const int16_t powers[] = {255, 128, 40, -40, -128, -255, 255, 0};
    for (const int16_t power : powers) {
        const int16_t other = static_cast<int16_t>(power / 2);
        port::motor(port::LEFT, power);
        port::motor(port::RIGHT, other);
        pass(port::MOTOR_WITHIN_MS * MS);
        if (const Finding found = expect_motors(power, other)) return found;
    }
    return nullptr;
}

Finding motors_hold() {
    port::motor(port::LEFT, 100);
    port::motor(port::RIGHT, -60);
    pass(500 * MS);
    const Finding found = expect_motors(100, -60);
    port::motor(port::LEFT, 0);
    port::motor(port::RIGHT, 0);
    pass(port::MOTOR_WITHIN_MS * MS);
    return found ? found : expect_motors(0, 0);
}

// --- the servos ---

uint32_t forget_pulses(uint8_t axis) {
    uint32_t count = 0;
    for (bench::Pulse seen; bench::pulse(axis, seen);) ++count;
    return count;
}

Finding servos_are_still_at_first() {
    if (!bench::sees_pulses()) return NOT_TESTED;
    pass(100 * MS);
    for (uint8_t axis = 0; axis < wax::AXES; ++axis)
        if (forget_pulses(axis) != 0) return "an axis had a pulse";
    return nullptr;
}

// All pulses of an axis in the next second: of this width, and as far apart as they should be.
Finding watch_pulses(uint8_t axis, uint16_t width_us) {
    uint32_t count = 0, last_us = 0;
    for (bench::Pulse seen; bench::pulse(axis, seen); ++count) {
        if (distance(static_cast<int32_t>(seen.width_us), width_us) > port::SERVO_ERROR_US)
            return wrong("a pulse had us", static_cast<int32_t>(seen.width_us), width_us);
        const int32_t apart_us = static_cast<int32_t>(seen.began_us - last_us);
        if (count > 0 && distance(apart_us, port::SERVO_EVERY_MS * 1000) > 1000)
            return wrong("us from pulse to pulse", apart_us, port::SERVO_EVERY_MS * 1000);
        last_us = seen.began_us;
    }
    const int32_t wanted = width_us ? 500 / port::SERVO_EVERY_MS : 0;
    return distance(static_cast<int32_t>(count), wanted) > (width_us ? 1 : 0)
               ? wrong("pulses in half a second", static_cast<int32_t>(count), wanted)
               : nullptr;
}

Finding servos_follow() {
    if (!bench::sees_pulses()) return NOT_TESTED;
    const uint16_t widths_us[][wax::AXES] = {
        {1000, 0, 0, 0}, {1500, 2000, 0, 500}, {2500, 1000, 1250, 1750}, {1000, 1000, 1000, 1000},
        {0, 0, 0, 0},
    };
    for (const auto &now_us : widths_us) {
        for (uint8_t axis = 0; axis < wax::AXES; ++axis) port::servo(axis, now_us[axis]);
        pass(port::SERVO_WITHIN_MS * MS);
        for (uint8_t axis = 0; axis < wax::AXES; ++axis) forget_pulses(axis);
        pass(500 * MS);
        for (uint8_t axis = 0; axis < wax::AXES; ++axis)
            if (const Finding found = watch_pulses(axis, now_us[axis])) return found;
    }
    return nullptr;
}

// While the width changes all the time no pulse is wider or narrower than any of them.
Finding servos_do_not_twitch() {
    if (!bench::sees_pulses()) return NOT_TESTED;
    for (uint16_t round = 0; round < 200; ++round) {
        port::servo(0, static_cast<uint16_t>(1200 + round % 2 * 600));
        pass(3 * MS);
    }
    Finding found = nullptr;
    for (bench::Pulse seen; bench::pulse(0, seen);) {
        const int32_t width_us = static_cast<int32_t>(seen.width_us);
        if (width_us < 1200 - port::SERVO_ERROR_US || width_us > 1800 + port::SERVO_ERROR_US)
            found = wrong("a pulse between 1200 and 1800 us had us", width_us, 1500);
    }
    port::servo(0, 0);
    pass(port::SERVO_WITHIN_MS * MS);
    forget_pulses(0);
    return found;
}

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

Finding turn_and_count(int32_t left, int32_t right) {
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
    port::feed_watchdog();
    const int32_t took_us = bench::hang(2 * port::WATCHDOG_MOST_MS * MS, motors_off);
    if (took_us == bench::CANNOT) return NOT_TESTED;
    if (took_us > static_cast<int32_t>(port::WATCHDOG_MOST_MS * MS))
        return wrong("it restarted after us", took_us, port::WATCHDOG_MOST_MS * MS);
    return motors_off ? nullptr : "the motors had power after it";
}

// --- the whole program, on this port ---

const uint16_t SESSION = 4711;
uint16_t sequence = 0;

const wax::Settings SETTINGS = {
    60000, 60000, 1, 2, 50,
    {{1000, 2000, 60000}, {1000, 2000, 60000}, {1000, 2000, 60000}, {1000, 2000, 60000}},
};
const wax::Body BODY = {1000, 50, 10000};

uint32_t robot_ms = 0;  // by the robot's clock, of its last report
uint32_t reported_us = 0;

// Send a frame as the server does; `payload` has `size` bytes.
void say(uint8_t type, uint16_t ttl_ms, const uint8_t *payload, uint8_t size) {
    uint8_t frame[wax::MAX_FRAME] = {wax::START_0, wax::START_1, size, type};
    ++sequence;
    const uint32_t time_ms = robot_ms + since(reported_us) / MS;
    frame[4] = static_cast<uint8_t>(sequence);
    frame[5] = static_cast<uint8_t>(sequence >> 8);
    frame[6] = 1;  // the turn
    frame[10] = static_cast<uint8_t>(ttl_ms);
    frame[11] = static_cast<uint8_t>(ttl_ms >> 8);
    for (uint8_t at = 0; at < 4; ++at) frame[12 + at] = static_cast<uint8_t>(time_ms >> 8 * at);
    memcpy(frame + wax::HEADER_SIZE, payload, size);
    const uint8_t covered = static_cast<uint8_t>(wax::HEADER_SIZE - wax::START_SIZE + size);
    const uint16_t crc = wax::crc16(frame + wax::START_SIZE, covered,
                                    type == wax::HELLO ? wax::NO_SESSION : SESSION);
    frame[wax::HEADER_SIZE + size] = static_cast<uint8_t>(crc >> 8);
    frame[wax::HEADER_SIZE + size + 1] = static_cast<uint8_t>(crc);
    bench::send(frame, static_cast<uint16_t>(wax::HEADER_SIZE + size + wax::CRC_SIZE));
}

// Let the program run; learn its clock from its reports, and count them.
uint16_t run_program(wax::Program &program, uint32_t us) {
    static uint8_t seen[2 * wax::REPORT_SIZE];
    static uint16_t count = 0;
    uint16_t reports = 0;
    for (const uint32_t began_us = bench::now_us(); since(began_us) < us;) {
        program.loop();
        bench::wait_us(500);
        const int32_t came =
            bench::sent(seen + count, static_cast<uint16_t>(sizeof seen - count));
        if (came > 0) count = static_cast<uint16_t>(count + came);
        uint16_t start = 0;
        while (start < count && seen[start] != wax::START_0) ++start;
        if (count - start >= wax::REPORT_SIZE && seen[start + 3] == wax::REPORT) {
            ++reports;
            reported_us = bench::now_us();
            robot_ms = 0;
            for (uint8_t at = 0; at < 4; ++at)
                robot_ms |= static_cast<uint32_t>(seen[start + 12 + at]) << 8 * at;
            start = static_cast<uint16_t>(start + wax::REPORT_SIZE);
        } else if (count == sizeof seen) {
            start = count;  // nothing that begins like a report ends like one
        }
        count = static_cast<uint16_t>(count - start);
        memmove(seen, seen + start, count);
    }
    return reports;
}

Finding the_program_drives_and_stops() {
    static wax::Program program(SETTINGS, BODY);
    const uint8_t session[] = {SESSION & 0xFF, SESSION >> 8};
    const uint8_t wheels[] = {0xF4, 0x01, 0x0C, 0xFE};  // 500 and -500 mm/s
    const uint8_t axis[] = {1, 0x10, 0x27};             // axis 1 to 10000
    const int16_t half = wax::power(500, BODY.full_speed_mmps, BODY.least_power);
    if (!bench::send(nullptr, 0)) return NOT_TESTED;
    run_program(program, 200 * MS);
    if (const Finding found = expect_motors(0, 0)) return found;

    say(wax::HELLO, 0, session, sizeof session);
    if (run_program(program, 150 * MS) < 2) return "it does not report 20 times a second";
    say(wax::AXIS, 200, axis, sizeof axis);
    for (uint8_t round = 0; round < 20; ++round) {
        say(wax::DRIVE, 200, wheels, sizeof wheels);
        run_program(program, 20 * MS);
    }
    if (const Finding found = expect_motors(half, static_cast<int16_t>(-half))) return found;
    if (bench::sees_pulses()) {
        bench::Pulse seen = {0, 0}, last = {0, 0};
        while (bench::pulse(1, seen)) last = seen;
        if (distance(static_cast<int32_t>(last.width_us), 2000) > port::SERVO_ERROR_US)
            return wrong("the axis had us", static_cast<int32_t>(last.width_us), 2000);
    }
    run_program(program, 150 * MS);
    if (const Finding found = expect_motors(half, static_cast<int16_t>(-half))) return found;
    run_program(program, 70 * MS);  // the time-to-live of 200 ms is over, braking included
    return expect_motors(0, 0);
}

struct Promise {
    const char *name;
    Finding (*test)();
};

const Promise PROMISES[] = {
    {"the motors are off at first", motors_are_off_at_first},
    {"the servos have no pulse at first", servos_are_still_at_first},
    {"the clock goes on", clock_goes_on},
    {"the clock goes on under load", clock_goes_on_under_load},
    {"noise differs", noise_differs},
    {"no call waits", nothing_waits},
    {"bytes are kept in their order", bytes_are_kept_in_order},
    {"reports are sent whole", reports_are_sent_whole},
    {"motors follow", motors_follow},
    {"motors hold", motors_hold},
    {"servos follow", servos_follow},
    {"servos do not twitch", servos_do_not_twitch},
    {"the battery is in proportion", battery_is_in_proportion},
    {"bumpers are felt", bumpers_are_felt},
    {"ticks are counted", ticks_are_counted},
    {"a living program is left alone", a_living_program_is_left_alone},
    {"the program drives and stops", the_program_drives_and_stops},
    {"a program that hangs is restarted", a_program_that_hangs_is_restarted},
};

}  // namespace

uint16_t run() {
    uint16_t broken = 0;
    port::begin();
    for (const Promise &promise : PROMISES) {
        const Finding found = promise.test();
        char line[160];
        if (found == nullptr)
            snprintf(line, sizeof line, "ok - %s", promise.name);
        else if (found == NOT_TESTED)
            snprintf(line, sizeof line, "not tested - %s: the bench cannot", promise.name);
        else
            snprintf(line, sizeof line, "BROKEN - %s: %s", promise.name, found);
        bench::say(line);
        broken = static_cast<uint16_t>(broken + (found != nullptr && found != NOT_TESTED));
    }
    return broken;
}

}  // namespace port_test
