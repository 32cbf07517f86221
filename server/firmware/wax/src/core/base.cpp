#include "base.h"

namespace wax {

namespace {

int32_t size_of(int32_t speed) { return speed < 0 ? -speed : speed; }

// Write the speed of each wheel, in the unit of the parts.
void turn(Kind kind, const int32_t *parts, int32_t *wheels) {
    const int32_t ahead = parts[0], aside = parts[1], spin = parts[2];
    if (kind == Kind::MECANUM) {
        wheels[0] = ahead - aside - spin;
        wheels[1] = ahead + aside + spin;
        wheels[2] = ahead + aside - spin;
        wheels[3] = ahead - aside + spin;
        return;
    }
    const int32_t part = ahead / 500 * 433;  // half of the square root of 3
    wheels[0] = part - aside / 2 - spin;
    wheels[1] = part + aside / 2 + spin;
    wheels[2] = aside - spin;
}

// Slow all parts by one factor, so that the robot keeps its direction and its curve.
void fit(const Base &base, int32_t *parts) {
    while (size_of(parts[2]) > INT32_MAX / 4)  // or a sum of the three were too large
        for (uint8_t at = 0; at < PARTS; ++at) parts[at] /= 2;
    int32_t wheels[MAX_WHEELS] = {};
    turn(base.kind, parts, wheels);
    const int32_t fastest = base.fastest_mmps * INT32_C(1000);
    int32_t largest = fastest;
    for (const int32_t wheel : wheels)
        if (size_of(wheel) > largest) largest = size_of(wheel);
    for (uint8_t at = 0; at < PARTS; ++at)
        parts[at] = static_cast<int32_t>(static_cast<int64_t>(parts[at]) * fastest / largest);
}

}  // namespace

void read(const Base &base, const Frame &frame, int32_t *parts) {
    const int32_t left = frame.left_mmps, right = frame.right_mmps;
    parts[2] = 0;
    if (!base.moves_sideways()) {
        parts[0] = left * 1000;
        parts[1] = right * 1000;
        return;
    }
    parts[0] = (left + right) * 500;
    parts[1] = frame.lateral_mmps * INT32_C(1000);
    parts[2] = (right - left) * 500;
    if (frame.type == MOVE) {
        parts[0] = frame.linear_mmps * INT32_C(1000);
        parts[2] = static_cast<int32_t>(frame.angular_mradps) * base.arm_mm;
    }
    fit(base, parts);
}

void mix(const Base &base, const int32_t *parts, int16_t *mmps) {
    int32_t wheels[MAX_WHEELS] = {parts[0], parts[1], 0, 0};
    if (base.moves_sideways()) turn(base.kind, parts, wheels);
    for (uint8_t at = 0; at < MAX_WHEELS; ++at) mmps[at] = static_cast<int16_t>(wheels[at] / 1000);
}

}  // namespace wax
