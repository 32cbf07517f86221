// From a wheel's speed to the power of its motor.
#pragma once

#include <stdint.h>

namespace wax {

const int16_t FULL_POWER = 255;

// Power from -FULL_POWER to FULL_POWER: 0 at standstill, `least` at the slowest motion, all of it
// at `full_mmps` and above.
inline int16_t power(int16_t mmps, int16_t full_mmps, uint8_t least) {
    if (mmps == 0) return 0;
    const int32_t size = mmps < 0 ? -static_cast<int32_t>(mmps) : mmps;
    const int32_t share = least + (FULL_POWER - least) * size / full_mmps;
    const int16_t most = static_cast<int16_t>(share < FULL_POWER ? share : FULL_POWER);
    return static_cast<int16_t>(mmps < 0 ? -most : most);
}

}  // namespace wax
