#include "base.h"

namespace wax {

namespace {

int32_t size_of(int32_t speed) { return speed < 0 ? -speed : speed; }

// Slow all wheels by one factor, so that the robot keeps its direction and its curve.
void fit(int32_t *wanted, int16_t fastest, int16_t *wheels) {
    int32_t largest = fastest;
    for (uint8_t at = 0; at < MAX_WHEELS; ++at)
        if (size_of(wanted[at]) > largest) largest = size_of(wanted[at]);
    for (; largest > INT16_MAX; largest /= 2)  // or the products below were too large
        for (uint8_t at = 0; at < MAX_WHEELS; ++at) wanted[at] /= 2;
    for (uint8_t at = 0; at < MAX_WHEELS; ++at)
        wheels[at] = static_cast<int16_t>(wanted[at] * fastest / largest);
}

}  // namespace

void mix(const Base &base, const Frame &frame, int16_t *wheels) {
    if (!base.moves_sideways()) {
        wheels[0] = frame.left_mmps;
        wheels[1] = frame.right_mmps;
        return;
    }
    int32_t left = frame.left_mmps, right = frame.right_mmps;
    const int32_t aside = frame.lateral_mmps;
    if (frame.type == MOVE) {
        const int32_t spin = static_cast<int32_t>(frame.angular_mradps) * base.arm_mm / 1000;
        left = frame.linear_mmps - spin;
        right = frame.linear_mmps + spin;
    }
    int32_t wanted[MAX_WHEELS] = {left - aside, right + aside, left + aside, right - aside};
    if (base.kind == Kind::OMNI) {
        const int32_t ahead = (left + right) * 433 / 1000;  // half of the square root of 3, each
        const int32_t spin = (right - left) / 2;
        wanted[0] = ahead - aside / 2 - spin;
        wanted[1] = ahead + aside / 2 + spin;
        wanted[2] = aside - spin;
        wanted[3] = 0;
    }
    fit(wanted, base.fastest_mmps, wheels);
}

}  // namespace wax
