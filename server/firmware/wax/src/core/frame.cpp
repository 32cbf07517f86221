#include "frame.h"

#include "crc16.h"

namespace wax {

namespace {

uint16_t get16(const uint8_t *bytes) {
    return static_cast<uint16_t>(bytes[0] | bytes[1] << 8);
}

uint32_t get32(const uint8_t *bytes) {
    return get16(bytes) | static_cast<uint32_t>(get16(bytes + 2)) << 16;
}

uint8_t *put16(uint8_t *bytes, uint16_t value) {
    bytes[0] = static_cast<uint8_t>(value);
    bytes[1] = static_cast<uint8_t>(value >> 8);
    return bytes + 2;
}

uint8_t *put32(uint8_t *bytes, uint32_t value) {
    return put16(put16(bytes, static_cast<uint16_t>(value)), static_cast<uint16_t>(value >> 16));
}

// The CRC covers everything between the start and itself.
uint16_t crc_of(const uint8_t *bytes, uint8_t payload_size, uint16_t session) {
    const uint8_t size = static_cast<uint8_t>(HEADER_SIZE - START_SIZE + payload_size);
    return crc16(bytes + START_SIZE, size, session);
}

// High byte first, unlike all other numbers, so that the CRC detects any 16 damaged bits in a row.
bool crc_holds(const uint8_t *bytes, uint8_t payload_size, uint16_t session) {
    const uint8_t *at = bytes + HEADER_SIZE + payload_size;
    const uint16_t said = static_cast<uint16_t>(at[0] << 8 | at[1]);
    return crc_of(bytes, payload_size, session) == said;
}

bool read_payload(const uint8_t *payload, uint8_t size, Frame &frame) {
    switch (frame.type) {
        case HELLO:
            if (size != 2) return false;
            frame.session = get16(payload);
            return frame.session != 0 && frame.session != NO_SESSION;
        case DRIVE:
            if (size != 4) return false;
            frame.left_mmps = static_cast<int16_t>(get16(payload));
            frame.right_mmps = static_cast<int16_t>(get16(payload + 2));
            return true;
        case AXIS:
            if (size != 3) return false;
            frame.axis = payload[0];
            frame.position = static_cast<int16_t>(get16(payload + 1));
            return true;
        case STOP:
            return size == 0;
        case MOVE:
            if (size != 6) return false;
            frame.linear_mmps = static_cast<int16_t>(get16(payload));
            frame.lateral_mmps = static_cast<int16_t>(get16(payload + 2));
            frame.angular_mradps = static_cast<int16_t>(get16(payload + 4));
            return true;
        default:
            return false;
    }
}

}  // namespace

bool read_frame(const uint8_t *bytes, uint16_t session, Frame &frame) {
    const uint8_t size = bytes[2];
    frame = Frame();
    frame.type = bytes[3];
    const uint16_t start = frame.type == HELLO ? NO_SESSION : session;
    if (!crc_holds(bytes, size, start)) return false;
    frame.sequence = get16(bytes + 4);
    frame.turn = get32(bytes + 6);
    frame.ttl_ms = get16(bytes + 10);
    frame.time_ms = get32(bytes + 12);
    return read_payload(bytes + HEADER_SIZE, size, frame);
}

void write_report(const Report &report, uint16_t session, uint8_t *bytes) {
    uint8_t *at = bytes;
    *at++ = START_0;
    *at++ = START_1;
    *at++ = REPORT_SIZE - HEADER_SIZE - CRC_SIZE;
    *at++ = REPORT;
    at = put16(at, report.own_sequence);
    at = put32(at, report.turn);
    at = put16(at, 0);
    at = put32(at, report.time_ms);
    at = put16(at, report.battery_mv);
    *at++ = report.bumpers;
    at = put32(at, static_cast<uint32_t>(report.left_ticks));
    at = put32(at, static_cast<uint32_t>(report.right_ticks));
    *at++ = static_cast<uint8_t>((report.moving ? 1 : 0) | (report.timed_out ? 2 : 0) |
                                 (report.moves_sideways ? 4 : 0));
    at = put16(at, report.sequence);
    at = put16(at, report.damaged);
    at = put16(at, report.refused);
    const uint16_t crc = crc_of(bytes, REPORT_SIZE - HEADER_SIZE - CRC_SIZE, session);
    *at++ = static_cast<uint8_t>(crc >> 8);
    *at = static_cast<uint8_t>(crc);
}

}  // namespace wax
