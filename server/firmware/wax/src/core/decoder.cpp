#include "decoder.h"

#include <string.h>

namespace wax {

void Decoder::push(uint8_t byte) {
    if (size_ < MAX_FRAME) bytes_[size_++] = byte;
}

bool Decoder::next(uint16_t session, Frame &frame) {
    for (;;) {
        seek_start();
        if (size_ <= START_SIZE) return false;
        const uint8_t payload_size = bytes_[START_SIZE];
        if (payload_size > MAX_PAYLOAD) {
            ++damaged_;
            drop(1);
            continue;
        }
        const uint8_t frame_size = static_cast<uint8_t>(HEADER_SIZE + payload_size + CRC_SIZE);
        if (size_ < frame_size) return false;
        if (read_frame(bytes_, session, frame)) {
            drop(frame_size);
            return true;
        }
        ++damaged_;
        drop(1);
    }
}

void Decoder::seek_start() {
    uint8_t at = 0;
    while (at < size_ && (bytes_[at] != START_0 || (at + 1 < size_ && bytes_[at + 1] != START_1)))
        ++at;
    drop(at);
}

void Decoder::drop(uint8_t count) {
    size_ = static_cast<uint8_t>(size_ - count);
    memmove(bytes_, bytes_ + count, size_);
}

}  // namespace wax
