#include "board.h"

namespace {

const double MM_A_TICK = 0.5;
const uint16_t BATTERY_MV = 7400;
const double SETTLED_AFTER_S = 0.005;

// Of a base that moves sideways; a diagonal of 1 m/s needs no wheel slowed.
const uint16_t ARM_MM = 200;
const int16_t FASTEST_MMPS = 2000;

uint32_t ms(double now_s) { return static_cast<uint32_t>(static_cast<uint64_t>(now_s * 1000.0)); }

const char *name_of(uint8_t type) {
    switch (type) {
        case wax::HELLO: return "hello";
        case wax::DRIVE: return "drive";
        case wax::AXIS: return "axis";
        case wax::MOVE: return "move";
        default: return "stop";
    }
}

const char *name_of(wax::Verdict verdict) {
    switch (verdict) {
        case wax::Verdict::OLD_TURN: return "old turn";
        case wax::Verdict::OLD_SEQUENCE: return "old sequence";
        case wax::Verdict::LATE: return "late";
        case wax::Verdict::TIMED_OUT: return "timed out";
        case wax::Verdict::CANNOT: return "cannot";
        default: return "taken";
    }
}

wax::Settings settings_for(wax::Kind kind) {
    wax::Settings settings = config::SETTINGS;
    if (kind != wax::Kind::SIDES) settings.base = {kind, ARM_MM, FASTEST_MMPS, 0, 0};
    return settings;
}

}  // namespace

Board::Board(Log &log, uint32_t boot_ms, wax::Kind kind, double now_s)
    : log_(log),
      boot_ms_(boot_ms),
      settings_(settings_for(kind)),
      robot_(settings_, ms(now_s)),
      inputs_() {
    inputs_.battery_mv = BATTERY_MV;
    reset(now_s);
}

void Board::reset(double now_s) {
    robot_ = wax::Robot(settings_, ms(now_s));
    left_mm_ = right_mm_ = 0.0;
    timed_out_ = false;
    damaged_ = 0;
    booted_s_ = now_s + boot_ms_ / 1000.0;
    ticked_s_ = changed_s_ = now_s;
    log_.say(now_s, "start");
    tell_wheels(now_s);
}

void Board::hear(const uint8_t *bytes, size_t size, double now_s) {
    if (boots(now_s)) return;
    for (size_t at = 0; at < size; ++at) {
        robot_.push(bytes[at]);
        for (;;) {
            wax::Frame frame;
            const wax::Verdict verdict = robot_.next(ms(now_s), frame);
            if (robot_.damaged() != damaged_) {
                damaged_ = robot_.damaged();
                log_.say(now_s, "damaged", "\"count\": %u", damaged_);
            }
            if (verdict == wax::Verdict::NOTHING) break;
            tell(frame, verdict, now_s);
        }
    }
}

void Board::tick(double now_s) {
    const double elapsed_s = now_s - ticked_s_;
    ticked_s_ = now_s;
    left_mm_ += robot_.mmps(0) * elapsed_s;
    right_mm_ += robot_.mmps(1) * elapsed_s;
    inputs_.left_ticks = static_cast<int32_t>(left_mm_ / MM_A_TICK);
    inputs_.right_ticks = static_cast<int32_t>(right_mm_ / MM_A_TICK);
    if (boots(now_s)) return;
    robot_.tick(ms(now_s), inputs_);
    if (robot_.timed_out() != timed_out_) {
        timed_out_ = robot_.timed_out();
        if (timed_out_) log_.say(now_s, "ttl");
    }
    tell_wheels(now_s);
}

bool Board::report(double now_s, uint8_t *bytes) {
    return !boots(now_s) && robot_.report(ms(now_s), bytes);
}

void Board::tell(const wax::Frame &frame, wax::Verdict verdict, double now_s) {
    char move[80] = "";
    if (frame.type == wax::MOVE)
        snprintf(move, sizeof move, ", \"linear\": %d, \"lateral\": %d, \"angular\": %d",
                 frame.linear_mmps, frame.lateral_mmps, frame.angular_mradps);
    log_.say(now_s, "frame",
             "\"type\": \"%s\", \"verdict\": \"%s\", \"session\": %u, \"turn\": %lu, "
             "\"sequence\": %u, \"ttl_ms\": %u, \"time_ms\": %lu, \"left\": %d, \"right\": %d, "
             "\"axis\": %u, \"position\": %d%s",
             name_of(frame.type), name_of(verdict), frame.session,
             static_cast<unsigned long>(frame.turn), frame.sequence, frame.ttl_ms,
             static_cast<unsigned long>(frame.time_ms), frame.left_mmps, frame.right_mmps,
             frame.axis, frame.position, move);
}

// A line when the speeds begin to change, and one when they have: starts, stops and new speeds.
void Board::tell_wheels(double now_s) {
    bool changed = false, stands = true;
    for (uint8_t at = 0; at < wax::MAX_WHEELS; ++at) {
        changed = changed || robot_.mmps(at) != mmps_[at];
        mmps_[at] = robot_.mmps(at);
        stands = stands && mmps_[at] == 0;
    }
    if (changed) changed_s_ = now_s;
    const bool changing = !stands && now_s - changed_s_ < SETTLED_AFTER_S;
    if (changing == changing_ && !(changed && stands)) return;
    changing_ = changing;
    char back[64] = "";
    if (robot_.wheels() == 3) snprintf(back, sizeof back, ", \"back\": %d", mmps_[2]);
    if (robot_.wheels() == 4)
        snprintf(back, sizeof back, ", \"back_left\": %d, \"back_right\": %d", mmps_[2], mmps_[3]);
    log_.say(now_s, "wheels", "\"left\": %d, \"right\": %d%s", mmps_[0], mmps_[1], back);
}
