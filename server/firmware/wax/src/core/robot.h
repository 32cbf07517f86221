// The robot's reaction to frames: the last of four watchdogs, independent of the others.
//
// Time is any clock of milliseconds that wraps at 2^32. No heap, no float, no Arduino.
#pragma once

#include <stdint.h>

#include "base.h"
#include "decoder.h"
#include "frame.h"
#include "ramp.h"
#include "servo.h"

namespace wax {

const uint8_t AXES = 4;
const uint8_t REPORT_EVERY_MS = 50;
const uint16_t MAX_TTL_MS = 1000;
const uint8_t MAX_AHEAD_MS = 50;

struct Settings {
    uint16_t acceleration_mmps2;
    uint16_t braking_mmps2;
    uint8_t front_bumpers, back_bumpers;  // the bits that block forward, and backward
    uint8_t still_ms;  // a wheel without an encoder tick for this long stands
    ServoRange servos[AXES];
    Base base;
};

struct Inputs {
    uint16_t battery_mv;
    uint8_t bumpers;
    int32_t left_ticks, right_ticks;
};

enum class Verdict : uint8_t { NOTHING, TAKEN, OLD_TURN, OLD_SEQUENCE, LATE, TIMED_OUT, CANNOT };

class Robot {
public:
    // Start without a session, at standstill.
    Robot(const Settings &settings, uint32_t now_ms);

    // Add a byte from the line. After each, call `next` until it returns NOTHING.
    void push(uint8_t byte) { decoder_.push(byte); }

    // Check the next complete frame and, if it is TAKEN, apply it.
    Verdict next(uint32_t now_ms, Frame &frame);

    // Advance time: stop what has expired, and move the wheels' speeds towards their targets.
    // Call it at least every few milliseconds, and after the frames.
    void tick(uint32_t now_ms, const Inputs &inputs);

    // Write a report of REPORT_SIZE bytes if one is due; else return false.
    bool report(uint32_t now_ms, uint8_t *bytes);

    // How many wheels it has, and the current set-point of one of them.
    uint8_t wheels() const { return settings_.base.wheels(); }
    int16_t mmps(uint8_t wheel) const { return mmps_[wheel]; }

    // The target of an axis below AXES, -FULL_POSITION to FULL_POSITION.
    int16_t axis(uint8_t number) const { return axes_[number]; }

    // The pulse of an axis's servo; 0, which is none, until it was told where to go. So nothing
    // moves when power comes.
    uint16_t servo_us(uint8_t number) const { return servos_[number].pulse_us(); }

    bool moving() const { return moving_; }
    bool timed_out() const { return timed_out_; }
    uint16_t damaged() const { return decoder_.damaged(); }

private:
    Verdict judge(const Frame &frame, uint32_t now_ms) const;
    void obey(const Frame &frame, uint32_t now_ms);
    bool is_newer(uint16_t sequence) const;
    bool is_late(const Frame &frame, uint32_t now_ms) const;
    bool has_run_out(uint32_t now_ms) const;
    void go(const Frame &frame);
    void stand();
    void ramp(const int32_t *targets, uint8_t step_ms);
    void watch_wheels(uint32_t now_ms, const Inputs &inputs);

    Settings settings_;
    Decoder decoder_;
    Ramp parts_[PARTS];
    int16_t mmps_[MAX_WHEELS] = {};
    Inputs inputs_ = Inputs();

    uint16_t session_ = NO_SESSION;
    uint32_t turn_ = 0;
    uint16_t sequence_ = 0;
    uint32_t hello_ms_;

    bool driven_ = false;
    int32_t wanted_[PARTS] = {};
    uint8_t blocking_ = 0;  // the bumpers' bits that end this motion
    uint32_t arrived_ms_ = 0;
    uint16_t ttl_ms_ = 0;
    bool timed_out_ = false;
    int16_t axes_[AXES] = {};
    uint8_t told_axes_ = 0;  // one bit each
    Servo servos_[AXES];

    uint32_t ticked_ms_;
    uint32_t turned_ms_;
    bool turning_ = false;
    bool moving_ = false;

    uint32_t reported_ms_;
    bool report_now_ = false;
    uint16_t own_sequence_ = 0;
    uint16_t refused_ = 0;
};

}  // namespace wax
