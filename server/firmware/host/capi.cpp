// The core behind C functions, for tests that turn its clock by hand.
#include <stdint.h>

#include "../wax/src/core/battery.h"
#include "../wax/src/core/power.h"
#include "../wax/src/core/robot.h"

extern "C" {

// All that can be asked about a robot, and of a frame what its verdict was about.
struct WaxState {
    int16_t wheels_mmps[wax::MAX_WHEELS];
    int16_t axes[wax::AXES];
    uint16_t servos_us[wax::AXES];
    uint8_t moving, timed_out;
    uint16_t damaged;
};

struct WaxFrame {
    uint8_t type, axis, verdict;
    uint16_t sequence, ttl_ms, session;
    uint32_t turn, time_ms;
    int16_t left_mmps, right_mmps, linear_mmps, lateral_mmps, angular_mradps, position;
};

wax::Robot *wax_new(uint16_t acceleration_mmps2, uint16_t braking_mmps2, uint8_t front_bumpers,
                    uint8_t back_bumpers, uint8_t still_ms, uint16_t least_us, uint16_t most_us,
                    uint16_t us_per_s, uint8_t kind, uint16_t arm_mm, int16_t fastest_mmps,
                    uint8_t left_bumpers, uint8_t right_bumpers, uint32_t now_ms) {
    const wax::ServoRange servo = {least_us, most_us, us_per_s};
    const wax::Settings settings = {acceleration_mmps2, braking_mmps2, front_bumpers, back_bumpers,
                                    still_ms,           {servo, servo, servo, servo},
                                    {static_cast<wax::Kind>(kind), arm_mm, fastest_mmps,
                                     left_bumpers, right_bumpers}};
    return new wax::Robot(settings, now_ms);
}

void wax_delete(wax::Robot *robot) { delete robot; }

void wax_push(wax::Robot *robot, uint8_t byte) { robot->push(byte); }

static uint8_t next(wax::Robot *robot, uint32_t now_ms, WaxFrame *out) {
    wax::Frame frame;
    const wax::Verdict verdict = robot->next(now_ms, frame);
    if (verdict == wax::Verdict::NOTHING) return 0;
    *out = {frame.type,    frame.axis,    static_cast<uint8_t>(verdict),
            frame.sequence, frame.ttl_ms, frame.session,
            frame.turn,     frame.time_ms, frame.left_mmps,
            frame.right_mmps, frame.linear_mmps, frame.lateral_mmps,
            frame.angular_mradps, frame.position};
    return 1;
}

uint8_t wax_next(wax::Robot *robot, uint32_t now_ms, WaxFrame *out) {
    return next(robot, now_ms, out);
}

// Hear bytes as the sketch does; writes a frame for each verdict, of which there are fewer than
// bytes, and returns how many.
uint32_t wax_hear(wax::Robot *robot, const uint8_t *bytes, uint32_t size, uint32_t now_ms,
                  WaxFrame *out) {
    uint32_t count = 0;
    for (uint32_t at = 0; at < size; ++at) {
        robot->push(bytes[at]);
        while (next(robot, now_ms, out + count)) ++count;
    }
    return count;
}

void wax_tick(wax::Robot *robot, uint32_t now_ms, uint16_t battery_mv, uint8_t bumpers,
              int32_t left_ticks, int32_t right_ticks) {
    const wax::Inputs inputs = {battery_mv, bumpers, left_ticks, right_ticks};
    robot->tick(now_ms, inputs);
}

uint8_t wax_report(wax::Robot *robot, uint32_t now_ms, uint8_t *bytes) {
    return robot->report(now_ms, bytes) ? wax::REPORT_SIZE : 0;
}

void wax_state(const wax::Robot *robot, WaxState *out) {
    for (uint8_t at = 0; at < wax::MAX_WHEELS; ++at) out->wheels_mmps[at] = robot->mmps(at);
    for (uint8_t at = 0; at < wax::AXES; ++at) out->axes[at] = robot->axis(at);
    for (uint8_t at = 0; at < wax::AXES; ++at) out->servos_us[at] = robot->servo_us(at);
    out->moving = robot->moving();
    out->timed_out = robot->timed_out();
    out->damaged = robot->damaged();
}

int16_t wax_power(int16_t mmps, int16_t full_mmps, uint8_t least) {
    return wax::power(mmps, full_mmps, least);
}

// The voltages after each of these numbers.
void wax_battery(uint16_t full_scale, uint16_t full_mv, const uint16_t *numbers, uint32_t count,
                 uint16_t *mv) {
    wax::Battery battery(full_scale, full_mv);
    for (uint32_t at = 0; at < count; ++at) {
        battery.sample(numbers[at]);
        mv[at] = battery.mv();
    }
}

}  // extern "C"
