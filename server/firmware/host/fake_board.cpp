#include "fake_board.h"

#include <stdio.h>
#include <string.h>

#include <algorithm>
#include <deque>

#include "../port_test/bench.h"
#include "../wax/src/port.h"

namespace fake {

const char *const FAULTS[] = {
    "motors run at first",    "servos pulse at first",   "clock goes back",
    "clock jumps",            "clock is slow",           "clock waits for the line",
    "noise is constant",      "read waits",              "buffer is small",
    "bytes come backward",    "bytes are made up",       "room is small",
    "bytes are lost",         "bytes are damaged",       "motor is late",
    "motor is reversed",      "motors are swapped",      "motor is weak",
    "motor falls asleep",     "motor does not brake",    "pulses are wide",
    "pulses are rare",        "pulses do not end",       "servos are swapped",
    "pulses twitch",          "battery is half",         "battery has 16 bits",
    "bumper sticks",          "ticks are lost",          "ticks count up only",
    "ticks are made up",      "watchdog sleeps",         "watchdog is slow",
    "watchdog is hasty",      "restarts with power",     "back motors are swapped",
};
const unsigned FAULT_COUNT = sizeof FAULTS / sizeof *FAULTS;

namespace {

const char *fault = "";
bool is_blind = false;

}  // namespace

bool break_it(const char *name) {
    for (const char *known : FAULTS)
        if (strcmp(known, name) == 0) fault = known;
    return strcmp(fault, name) == 0;
}

void blind_it() { is_blind = true; }

namespace {

bool has(const char *name) { return strcmp(fault, name) == 0; }

const uint64_t BYTE_US = 87;  // at 115200 bit/s
const uint64_t STEP_US = 5;
const uint64_t CALL_US = 2;
const uint64_t CLOCK_BEGAN_MS = 0xFFFFFF00;  // soon at its end

uint64_t now = 0;
uint64_t clock_us = CLOCK_BEGAN_MS * 1000;  // the board's own

struct Coming {
    uint64_t at_us;
    uint8_t byte;
};
std::deque<Coming> coming;
std::deque<uint8_t> received, sending, line;
uint64_t sent_at_us = 0;

struct Motor {
    int16_t power = 0, next = 0;
    uint64_t from_us = 0, set_us = 0;
} motors[wax::MAX_WHEELS];

struct ServoOut {
    uint16_t wanted_us = 0, width_us = 0;
    uint64_t ends_us = 0;
    std::deque<bench::Pulse> seen;
} servos[wax::AXES];
uint64_t round_us = 0;

struct Encoder {
    int32_t left = 0;
    uint64_t next_us = 0, every_us = 0;
    int32_t count = 0;
} encoders[2];

uint16_t charge_thousandths = 0;
uint8_t pressed = 0;
uint64_t fed_us = 0;
bool runs = false;
int32_t restart_count = 0;

uint64_t watchdog_us() {
    return has("watchdog is slow") ? 400000 : has("watchdog is hasty") ? 15000 : 100000;
}

void turn_off() {
    for (Motor &motor : motors)
        if (!has("restarts with power")) motor.power = motor.next = 0;
    for (ServoOut &servo : servos) servo.wanted_us = 0;
}

void carry_bytes() {
    for (; !coming.empty() && coming.front().at_us <= now; coming.pop_front()) {
        if (has("clock waits for the line")) clock_us -= std::min<uint64_t>(STEP_US, BYTE_US);
        const size_t most = has("buffer is small") ? 40 : 64;
        if (received.size() < most) received.push_back(coming.front().byte);
    }
    for (; !sending.empty() && now - sent_at_us >= BYTE_US; sending.pop_front()) {
        sent_at_us = now;
        if (has("bytes are lost") && sending.size() == 7) continue;
        line.push_back(has("bytes are damaged") && sending.size() == 7 ? 0xEE : sending.front());
    }
}

void give_pulses() {
    const uint64_t every_us = has("pulses are rare") ? 30000 : 20000;
    if (now - round_us >= every_us) {
        round_us = now;
        for (ServoOut &servo : servos) {
            if (servo.wanted_us || !has("pulses do not end")) servo.width_us = servo.wanted_us;
            const uint32_t wide_us = servo.width_us + (has("pulses are wide") ? 50u : 0u);
            if (servo.width_us) servo.ends_us = now + wide_us;
        }
    }
    for (ServoOut &servo : servos)
        if (servo.ends_us && now >= servo.ends_us) {
            const uint32_t width_us = static_cast<uint32_t>(now - round_us);
            servo.seen.push_back({static_cast<uint32_t>(round_us), width_us});
            servo.ends_us = 0;
        }
}

void turn_encoders() {
    for (Encoder &encoder : encoders)
        for (; encoder.left != 0 && now >= encoder.next_us; encoder.next_us += encoder.every_us) {
            const int32_t step = encoder.left > 0 ? 1 : -1;
            encoder.left -= step;
            if (has("ticks are lost") && encoder.left % 50 == 0) continue;
            encoder.count += has("ticks count up only") ? 1 : step;
        }
    if (has("ticks are made up") && now % 50000 < STEP_US) ++encoders[0].count;
}

void advance(uint64_t us) {
    for (const uint64_t ends = now + us; now < ends;) {
        const uint64_t step_us = std::min(STEP_US, ends - now);
        now += step_us;
        clock_us += step_us;
        if (has("clock is slow") && now % 100 < STEP_US) clock_us -= STEP_US;
        carry_bytes();
        give_pulses();
        turn_encoders();
        for (Motor &motor : motors) {
            if (now >= motor.from_us) motor.power = motor.next;
            if (has("motor falls asleep") && now - motor.set_us > 300000) motor.power = 0;
        }
        if (runs && !has("watchdog sleeps") && now - fed_us > watchdog_us()) {
            ++restart_count;
            fed_us = now;
            turn_off();
        }
    }
}

}  // namespace

}  // namespace fake

namespace port {

using fake::advance;
using fake::has;

void begin() {
    fake::runs = true;
    fake::fed_us = fake::now;
    if (has("motors run at first")) fake::motors[0].power = fake::motors[0].next = 90;
    if (has("servos pulse at first")) fake::servos[2].wanted_us = 1500;
}

uint32_t now_ms() {
    advance(fake::CALL_US);
    uint64_t ms = fake::clock_us / 1000;
    if (has("clock goes back") && ms % 64 == 63) ms -= 4;
    if (has("clock jumps")) ms -= ms % 5;
    return static_cast<uint32_t>(ms);
}

uint32_t noise() {
    static uint32_t state = 1;
    advance(1000);
    if (!has("noise is constant")) state = state * 1664525 + 1013904223;
    return state;
}

bool read(uint8_t &byte) {
    advance(has("read waits") ? 1000 : fake::CALL_US);
    if (fake::received.empty()) {
        byte = 0;
        return has("bytes are made up");
    }
    if (has("bytes come backward")) {
        byte = fake::received.back();
        fake::received.pop_back();
    } else {
        byte = fake::received.front();
        fake::received.pop_front();
    }
    return true;
}

uint16_t room() {
    advance(fake::CALL_US);
    const size_t most = has("room is small") ? 32 : 64;
    return static_cast<uint16_t>(most - std::min(most, fake::sending.size()));
}

void write(const uint8_t *bytes, uint8_t size) {
    advance(fake::CALL_US);
    fake::sending.insert(fake::sending.end(), bytes, bytes + size);
}

void motor(Wheel wheel, int16_t power) {
    advance(fake::CALL_US);
    const bool are_swapped =
        has("motors are swapped") || (has("back motors are swapped") && wheel >= port::BACK_LEFT);
    fake::Motor &motor = fake::motors[are_swapped ? wheel ^ 1 : wheel];
    if (has("motor does not brake") && power == 0) return;
    if (has("motor is reversed")) power = static_cast<int16_t>(-power);
    if (has("motor is weak")) power = static_cast<int16_t>(power * 9 / 10);
    motor.set_us = fake::now;
    if (power == motor.next) return;
    motor.next = power;
    motor.from_us = fake::now + (has("motor is late") ? 20000 : 1000);
}

void servo(uint8_t axis, uint16_t pulse_us) {
    advance(fake::CALL_US);
    fake::ServoOut &servo = fake::servos[has("servos are swapped") ? wax::AXES - 1 - axis : axis];
    servo.wanted_us = pulse_us;
    // As one that writes the timer while a pulse is under way.
    if (has("pulses twitch") && servo.ends_us) servo.ends_us = fake::now + 100;
}

uint16_t battery() {
    advance(100);
    const uint32_t share = fake::charge_thousandths / (has("battery is half") ? 2u : 1u);
    return static_cast<uint16_t>(battery_full_scale() * share / 1000);
}

uint16_t battery_full_scale() { return has("battery has 16 bits") ? 65535 : 1023; }

uint8_t bumpers() {
    advance(fake::CALL_US);
    return static_cast<uint8_t>(fake::pressed | (has("bumper sticks") ? 2 : 0));
}

int32_t ticks(Wheel wheel) {
    advance(fake::CALL_US);
    return fake::encoders[wheel].count;
}

void feed_watchdog() {
    advance(1);
    fake::fed_us = fake::now;
}

}  // namespace port

namespace bench {

using fake::is_blind;

uint32_t now_us() { return static_cast<uint32_t>(fake::now); }

void wait_us(uint32_t us) { fake::advance(us); }

void say(const char *line) { puts(line); }

bool send(const uint8_t *bytes, uint16_t size) {
    uint64_t at_us = fake::coming.empty() ? fake::now : fake::coming.back().at_us;
    for (uint16_t at = 0; at < size && !is_blind; ++at)
        fake::coming.push_back({at_us += fake::BYTE_US, bytes[at]});
    return !is_blind;
}

int32_t sent(uint8_t *bytes, uint16_t size) {
    if (is_blind) return CANNOT;
    const size_t count = std::min<size_t>(size, fake::line.size());
    std::copy_n(fake::line.begin(), count, bytes);
    fake::line.erase(fake::line.begin(), fake::line.begin() + static_cast<long>(count));
    return static_cast<int32_t>(count);
}

int32_t motor(port::Wheel wheel) { return is_blind ? CANNOT : fake::motors[wheel].power; }

bool pulse(uint8_t axis, Pulse &seen) {
    std::deque<Pulse> &all = fake::servos[axis].seen;
    if (all.empty()) return false;
    seen = all.front();
    all.pop_front();
    return true;
}

bool sees_pulses() { return !is_blind; }

bool turn(int32_t left, int32_t right, uint32_t per_s) {
    const int32_t ticks[] = {left, right};
    for (uint8_t wheel = 0; wheel < 2 && !is_blind; ++wheel) {
        fake::encoders[wheel].left = ticks[wheel];
        fake::encoders[wheel].every_us = 1000000 / per_s;
        fake::encoders[wheel].next_us = fake::now;
    }
    return !is_blind;
}

bool charge(uint16_t thousandths) {
    fake::charge_thousandths = thousandths;
    return !is_blind;
}

bool press(uint8_t bits) {
    fake::pressed = bits;
    return !is_blind;
}

uint8_t bumpers() { return 0x0F; }

int32_t restarts() { return is_blind ? CANNOT : fake::restart_count; }

int32_t hang(uint32_t patience_us, bool &motors_off) {
    if (is_blind) return CANNOT;
    const uint64_t began = fake::now;
    for (const int32_t before = fake::restart_count; fake::restart_count == before;) {
        if (fake::now - began >= patience_us) break;
        fake::advance(1000);
    }
    motors_off = std::all_of(fake::motors, fake::motors + wax::MAX_WHEELS,
                             [](const fake::Motor &motor) { return motor.power == 0; });
    return static_cast<int32_t>(fake::now - began);
}

}  // namespace bench
