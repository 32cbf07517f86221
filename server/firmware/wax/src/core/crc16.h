// CRC-16, polynomial 1021, not reflected, no final xor; bit by bit, because a table costs memory.
#pragma once

#include <stdint.h>

namespace wax {

inline uint16_t crc16(const uint8_t *data, uint8_t size, uint16_t start) {
    uint16_t crc = start;
    for (uint8_t at = 0; at < size; ++at) {
        crc = static_cast<uint16_t>(crc ^ (data[at] << 8));
        for (uint8_t bit = 0; bit < 8; ++bit) {
            const uint16_t shifted = static_cast<uint16_t>(crc << 1);
            crc = (crc & 0x8000u) ? static_cast<uint16_t>(shifted ^ 0x1021u) : shifted;
        }
    }
    return crc;
}

}  // namespace wax
