#include "ramp.h"

namespace wax {

namespace {

int32_t least(int32_t a, int32_t b) { return a < b ? a : b; }
int32_t most(int32_t a, int32_t b) { return a > b ? a : b; }

}  // namespace

void Ramp::approach(int16_t target_mmps, uint8_t elapsed_ms) {
    const int32_t target = target_mmps * INT32_C(1000);
    const int32_t faster = static_cast<int32_t>(acceleration_) * elapsed_ms;
    const int32_t slower = static_cast<int32_t>(braking_) * elapsed_ms;
    if (speed_ > 0) {
        speed_ = target >= speed_ ? least(speed_ + faster, target)
                                  : most(speed_ - slower, most(target, 0));
    } else if (speed_ < 0) {
        speed_ = target <= speed_ ? most(speed_ - faster, target)
                                  : least(speed_ + slower, least(target, 0));
    } else {
        speed_ = target >= 0 ? least(faster, target) : most(-faster, target);
    }
}

}  // namespace wax
