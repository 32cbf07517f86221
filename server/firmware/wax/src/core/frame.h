// The frames described byte by byte in server/wax/robot/serial/frames.py.
#pragma once

#include <stdint.h>

namespace wax {

const uint8_t START_0 = 0xA5;
const uint8_t START_1 = 0x5A;
const uint8_t START_SIZE = 2;
const uint8_t HEADER_SIZE = 16;
const uint8_t CRC_SIZE = 2;
const uint8_t MAX_PAYLOAD = 32;
const uint8_t MAX_FRAME = HEADER_SIZE + MAX_PAYLOAD + CRC_SIZE;
const uint8_t REPORT_SIZE = HEADER_SIZE + 18 + CRC_SIZE;
const uint16_t NO_SESSION = 0xFFFF;
const int16_t FULL_POSITION = 10000;

enum Type : uint8_t {
    HELLO = 0x00,
    DRIVE = 0x01,
    AXIS = 0x02,
    STOP = 0x03,
    MOVE = 0x04,
    REPORT = 0x81
};

// A frame from the server. Of the fields after `session` only those of its type are not 0.
struct Frame {
    uint8_t type;
    uint16_t sequence;
    uint32_t turn;
    uint16_t ttl_ms;
    uint32_t time_ms;
    uint16_t session;
    int16_t left_mmps, right_mmps;
    int16_t linear_mmps, lateral_mmps, angular_mradps;
    uint8_t axis;
    int16_t position;
};

// The robot's report.
struct Report {
    uint16_t own_sequence;
    uint32_t turn;
    uint32_t time_ms;
    uint16_t battery_mv;
    uint8_t bumpers;
    int32_t left_ticks, right_ticks;
    bool moving, timed_out, moves_sideways;
    uint16_t sequence, damaged, refused;
};

// Parse a complete frame, from its start to its CRC; false if it is not one of the server's or its
// CRC is wrong.
bool read_frame(const uint8_t *bytes, uint16_t session, Frame &frame);

// Write the REPORT_SIZE bytes of a report.
void write_report(const Report &report, uint16_t session, uint8_t *bytes);

}  // namespace wax
