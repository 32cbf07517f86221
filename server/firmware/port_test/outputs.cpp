#include "bench.h"
#include "finding.h"

namespace port_test {

// --- the motors ---

Finding motors_are_off_at_first() { return expect_motors(0, 0); }

Finding motors_follow() {
    const int16_t powers[] = {255, 128, 40, -40, -128, -255, 255, 0};
    for (const int16_t power : powers) {
        const int16_t other = static_cast<int16_t>(power / 2);
        port::motor(port::LEFT, power);
        port::motor(port::RIGHT, other);
        port::motor(port::BACK_LEFT, static_cast<int16_t>(-other));
        port::motor(port::BACK_RIGHT, static_cast<int16_t>(-power));
        pass(port::MOTOR_WITHIN_MS * MS);
        if (const Finding found = expect_motors(power, other, static_cast<int16_t>(-other),
                                                static_cast<int16_t>(-power)))
            return found;
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

static uint32_t forget_pulses(uint8_t axis) {
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
static Finding watch_pulses(uint8_t axis, uint16_t width_us) {
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

}  // namespace port_test
