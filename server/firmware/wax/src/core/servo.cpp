#include "servo.h"

#include "frame.h"

namespace wax {

void Servo::approach(int16_t position, uint8_t elapsed_ms) {
    const int32_t span_us = static_cast<int32_t>(range_.most_us) - range_.least_us;
    const int32_t from_least = static_cast<int32_t>(position) + FULL_POSITION;
    const int32_t target = (range_.least_us + span_us * from_least / (2 * FULL_POSITION)) * 1000;
    const int32_t step = static_cast<int32_t>(range_.us_per_s) * elapsed_ms;
    if (pulse_ == 0 || (pulse_ - step <= target && target <= pulse_ + step))
        pulse_ = target;
    else
        pulse_ += target > pulse_ ? step : -step;
}

}  // namespace wax
