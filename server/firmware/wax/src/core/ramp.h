// The speed of one wheel, with limited acceleration and braking.
#pragma once

#include <stdint.h>

namespace wax {

class Ramp {
public:
    // Both in mm/s per second.
    Ramp(uint16_t acceleration_mmps2, uint16_t braking_mmps2)
        : acceleration_(acceleration_mmps2), braking_(braking_mmps2) {}

    // Approach a target speed. A reversal goes through standstill.
    void approach(int16_t target_mmps, uint8_t elapsed_ms);

    int16_t mmps() const { return static_cast<int16_t>(speed_ / 1000); }
    bool stands() const { return speed_ == 0; }

private:
    uint16_t acceleration_, braking_;
    int32_t speed_ = 0;  // micrometres a second, so that steps of a millisecond are whole numbers
};

}  // namespace wax
