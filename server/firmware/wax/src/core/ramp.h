// One speed of the robot, such as a side's, with limited acceleration and braking.
#pragma once

#include <stdint.h>

namespace wax {

class Ramp {
public:
    // Both in mm/s per second.
    Ramp(uint16_t acceleration_mmps2, uint16_t braking_mmps2)
        : acceleration_(acceleration_mmps2), braking_(braking_mmps2) {}

    // Approach a target speed. A reversal goes through standstill.
    void approach(int32_t target, uint8_t elapsed_ms);

    // Approach the targets of two speeds at right angles, straight: their vector, not each of them,
    // has the limits of `ahead`. What must become slower does so first.
    static void approach_as_one(Ramp &ahead, Ramp &aside, const int32_t *targets,
                                uint8_t elapsed_ms);

    int32_t speed() const { return speed_; }

private:
    int32_t slowing(int32_t target) const;
    static uint8_t add(Ramp &ahead, Ramp &aside, int32_t x, int32_t y, uint16_t rate,
                       uint8_t elapsed_ms);

    uint16_t acceleration_, braking_;
    int32_t speed_ = 0;  // micrometres a second, so that steps of a millisecond are whole numbers
};

}  // namespace wax
