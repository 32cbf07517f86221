// Finds frames in a stream of bytes; keeps at most one unfinished frame.
#pragma once

#include <stdint.h>

#include "frame.h"

namespace wax {

class Decoder {
public:
    // Take a byte. After each, ask `next` until it says no: a byte may end several frames.
    void push(uint8_t byte);

    // Give the next whole frame of this session, if there is one. After garbage it goes on with
    // the next start that holds.
    bool next(uint16_t session, Frame &frame);

    // What began like a frame and was none, or none of the server's; wraps to 0.
    uint16_t damaged() const { return damaged_; }

private:
    void drop(uint8_t count);
    void seek_start();

    uint8_t bytes_[MAX_FRAME];
    uint8_t size_ = 0;
    uint16_t damaged_ = 0;
};

}  // namespace wax
