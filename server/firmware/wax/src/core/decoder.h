// Finds frames in a stream of bytes; keeps at most one unfinished frame.
#pragma once

#include <stdint.h>

#include "frame.h"

namespace wax {

class Decoder {
public:
    // Add a byte. After each, call `next` until it returns false: a byte may complete several
    // frames.
    void push(uint8_t byte);

    // Return the next complete frame of this session, if any. After garbage, continue with the next
    // valid start.
    bool next(uint16_t session, Frame &frame);

    // Counts what began like a frame but was none, or none of the server's; wraps to 0.
    uint16_t damaged() const { return damaged_; }

private:
    void drop(uint8_t count);
    void seek_start();

    uint8_t bytes_[MAX_FRAME];
    uint8_t size_ = 0;
    uint16_t damaged_ = 0;
};

}  // namespace wax
