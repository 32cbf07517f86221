// The pulses of one servo, with limited speed.
#pragma once

#include <stdint.h>

namespace wax {

struct ServoRange {
    uint16_t least_us, most_us;  // the pulses at -FULL_POSITION and FULL_POSITION; either is larger
    uint16_t us_per_s;           // how fast the pulse may change
};

class Servo {
public:
    explicit Servo(const ServoRange &range) : range_(range) {}

    // Approach a position. The first is taken at once, since nobody knows where the servo stands.
    void approach(int16_t position, uint8_t elapsed_ms);

    // The width of the pulse; 0 is none, before the first position.
    uint16_t pulse_us() const { return static_cast<uint16_t>(pulse_ / 1000); }

private:
    ServoRange range_;
    int32_t pulse_ = 0;  // nanoseconds, so that steps of a millisecond are whole numbers
};

}  // namespace wax
