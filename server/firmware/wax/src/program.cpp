#include "program.h"

#include "core/power.h"

namespace wax {

namespace {

// Fewer than a full buffer: what comes while it is read must not keep the rest from being done.
const uint8_t BYTES_A_ROUND = 32;
const uint8_t BATTERY_EVERY_MS = 20;

}  // namespace

Program::Program(const Settings &settings, const Body &body)
    : body_(body),
      origin_ms_(port::noise()),
      robot_(settings, now_ms()),
      battery_(port::battery_full_scale(), body.battery_full_mv),
      battery_ms_(now_ms()) {
    battery_.sample(port::battery());
}

void Program::loop() {
    listen();
    robot_.tick(now_ms(), feel());
    act();
    report();
    port::feed_watchdog();
}

void Program::listen() {
    uint8_t byte;
    for (uint8_t count = 0; count < BYTES_A_ROUND && port::read(byte); ++count) {
        robot_.push(byte);
        Frame frame;
        while (robot_.next(now_ms(), frame) != Verdict::NOTHING) {
        }
    }
}

Inputs Program::feel() {
    if (now_ms() - battery_ms_ >= BATTERY_EVERY_MS) {
        battery_ms_ = now_ms();
        battery_.sample(port::battery());
    }
    Inputs now = Inputs();
    now.battery_mv = battery_.mv();
    now.bumpers = port::bumpers();
    now.left_ticks = port::ticks(port::LEFT);
    now.right_ticks = port::ticks(port::RIGHT);
    return now;
}

void Program::act() {
    for (uint8_t wheel = 0; wheel < robot_.wheels(); ++wheel)
        port::motor(static_cast<port::Wheel>(wheel),
                    power(robot_.mmps(wheel), body_.full_speed_mmps, body_.least_power));
    for (uint8_t axis = 0; axis < AXES; ++axis) port::servo(axis, robot_.servo_us(axis));
}

// None is made before there is room for it: what it tells must be of now.
void Program::report() {
    uint8_t bytes[REPORT_SIZE];
    if (port::room() >= REPORT_SIZE && robot_.report(now_ms(), bytes))
        port::write(bytes, sizeof bytes);
}

}  // namespace wax
