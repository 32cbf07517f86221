// The firmware's core with motors, encoders, bumpers and a battery that are made up.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "../wax/config.h"
#include "../wax/src/core/robot.h"
#include "log.h"

class Board {
public:
    Board(Log &log, uint32_t boot_ms, wax::Kind kind, double now_s);

    // Restart: for `boot_ms` it neither hears nor speaks, like a board in its boot loader.
    void reset(double now_s);

    void hear(const uint8_t *bytes, size_t size, double now_s);

    // Let time pass, at most a few milliseconds.
    void tick(double now_s);

    // Write a report of wax::REPORT_SIZE bytes, where one is due; else return false.
    bool report(double now_s, uint8_t *bytes);

    void press(uint8_t bumpers) { inputs_.bumpers = bumpers; }
    void charge(uint16_t battery_mv) { inputs_.battery_mv = battery_mv; }

private:
    bool boots(double now_s) const { return now_s < booted_s_; }
    void tell(const wax::Frame &frame, wax::Verdict verdict, double now_s);
    void tell_wheels(double now_s);

    Log &log_;
    uint32_t boot_ms_;
    wax::Settings settings_;
    wax::Robot robot_;
    wax::Inputs inputs_;
    double booted_s_;
    double ticked_s_, changed_s_ = 0.0;
    double left_mm_ = 0.0, right_mm_ = 0.0;
    int16_t mmps_[wax::MAX_WHEELS] = {};
    bool changing_ = false;
    bool timed_out_ = false;
    uint16_t damaged_ = 0;
};
