#include <string.h>

#include "../wax/src/core/crc16.h"
#include "../wax/src/program.h"
#include "bench.h"
#include "finding.h"

namespace port_test {

// --- the whole program, on this port ---

namespace {

const uint16_t SESSION = 4711;
uint16_t sequence = 0;

const wax::Settings SETTINGS = {
    60000, 60000, 1, 2, 50,
    {{1000, 2000, 60000}, {1000, 2000, 60000}, {1000, 2000, 60000}, {1000, 2000, 60000}},
    {wax::Kind::SIDES, 0, 1000, 0, 0},
};
const wax::Body BODY = {1000, 50, 10000};
const uint8_t HELLO[] = {SESSION & 0xFF, SESSION >> 8};

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

}  // namespace

Finding the_program_drives_and_stops() {
    static wax::Program program(SETTINGS, BODY);
    const uint8_t wheels[] = {0xF4, 0x01, 0x0C, 0xFE};  // 500 and -500 mm/s
    const uint8_t axis[] = {1, 0x10, 0x27};             // axis 1 to 10000
    const int16_t half = wax::power(500, BODY.full_speed_mmps, BODY.least_power);
    if (!bench::send(nullptr, 0)) return NOT_TESTED;
    run_program(program, 200 * MS);
    if (const Finding found = expect_motors(0, 0)) return found;

    say(wax::HELLO, 0, HELLO, sizeof HELLO);
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

Finding the_program_moves_sideways_and_stops() {
    static wax::Settings settings = SETTINGS;
    settings.base = {wax::Kind::MECANUM, 200, 1000, 0, 0};
    static wax::Program program(settings, BODY);
    const uint8_t move[] = {0xC8, 0x00, 0x2C, 0x01, 0xF4, 0x01};  // 200 and 300 mm/s, 500 mrad/s
    const int16_t wheels_mmps[] = {-200, 600, 400, 0};
    int16_t powers[wax::MAX_WHEELS];
    for (uint8_t at = 0; at < wax::MAX_WHEELS; ++at)
        powers[at] = wax::power(wheels_mmps[at], BODY.full_speed_mmps, BODY.least_power);
    if (bench::motor(port::BACK_RIGHT) == bench::CANNOT || !bench::send(nullptr, 0))
        return NOT_TESTED;
    run_program(program, 200 * MS);
    say(wax::HELLO, 0, HELLO, sizeof HELLO);
    run_program(program, 150 * MS);
    for (uint8_t round = 0; round < 20; ++round) {
        say(wax::MOVE, 200, move, sizeof move);
        run_program(program, 20 * MS);
    }
    run_program(program, 150 * MS);
    if (const Finding found = expect_motors(powers[0], powers[1], powers[2], powers[3]))
        return found;
    run_program(program, 70 * MS);  // the time-to-live of 200 ms is over, braking included
    return expect_motors(0, 0);
}

}  // namespace port_test
