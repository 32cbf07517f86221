// How a robot's wheels stand, and how fast each turns for a motion.
#pragma once

#include <stdint.h>

#include "frame.h"

namespace wax {

const uint8_t MAX_WHEELS = 4;

// A motion in parts, each in micrometres a second: of two sides left and right; of a base that moves
// sideways ahead, to the left, and a wheel's for turning to the left.
const uint8_t PARTS = 3;

// The wheels are numbered in this order, all of them forward positive but the back one of three.
enum class Kind : uint8_t {
    SIDES,    // left, right
    MECANUM,  // left and right in front, left and right at the back; their rollers form an X from above
    OMNI,     // left, right, back, at equal angles; the back one is positive to the left
};

struct Base {
    Kind kind;
    uint16_t arm_mm;       // how far a wheel drives, in mm, while the robot turns by a radian
    int16_t fastest_mmps;  // of a wheel; what needs more is slowed as a whole
    uint8_t left_bumpers, right_bumpers;  // the bits that block motion to the left, and to the right

    bool moves_sideways() const { return kind != Kind::SIDES; }
    uint8_t wheels() const { return kind == Kind::SIDES ? 2 : kind == Kind::OMNI ? 3 : 4; }
};

// Write the motion that a drive or a move asks for, as fast as the wheels can.
void read(const Base &base, const Frame &frame, int32_t *parts);

// Write the speed of each wheel for a motion.
void mix(const Base &base, const int32_t *parts, int16_t *mmps);

}  // namespace wax
