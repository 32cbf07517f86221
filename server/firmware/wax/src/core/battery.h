// A battery's voltage from an analog input that motors disturb.
#pragma once

#include <stdint.h>

namespace wax {

class Battery {
public:
    // `full_scale` is the input's largest number, at most 4095; there the battery has `full_mv`.
    Battery(uint16_t full_scale, uint16_t full_mv) : full_scale_(full_scale), full_mv_(full_mv) {}

    // Take a number; an eighth of a change counts at once, the first wholly.
    void sample(uint16_t number) {
        const uint32_t now = static_cast<uint32_t>(number) * PARTS;
        mean_ = sampled_ ? mean_ - mean_ / WEIGHT + now / WEIGHT : now;
        sampled_ = true;
    }

    uint16_t mv() const {
        return static_cast<uint16_t>((mean_ + PARTS / 2) / PARTS * full_mv_ / full_scale_);
    }

private:
    static const uint8_t PARTS = 64;
    static const uint8_t WEIGHT = 8;

    uint16_t full_scale_, full_mv_;
    uint32_t mean_ = 0;  // in parts of the input's unit, so that small changes are not lost
    bool sampled_ = false;
};

}  // namespace wax
