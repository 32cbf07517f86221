// The whole program of a board, on top of `port.h`.
#pragma once

#include <stdint.h>

#include "core/battery.h"
#include "core/body.h"
#include "core/robot.h"
#include "port.h"

namespace wax {

class Program {
public:
    // After `port::begin`.
    Program(const Settings &settings, const Body &body);

    // Call it all the time, at least every few milliseconds.
    void loop();

private:
    uint32_t now_ms() const { return port::now_ms() + origin_ms_; }
    void listen();
    Inputs feel();
    void act();
    void report();

    Body body_;
    uint32_t origin_ms_;  // random, so that frames from before a restart are stale after it
    Robot robot_;
    Battery battery_;
    uint32_t battery_ms_;
};

}  // namespace wax
