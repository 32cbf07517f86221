// How a robot's motors and battery are built.
#pragma once

#include <stdint.h>

namespace wax {

struct Body {
    int16_t full_speed_mmps;   // of a wheel at full power
    uint8_t least_power;       // of 255, at which it just turns
    uint16_t battery_full_mv;  // at the battery input's full scale
};

}  // namespace wax
