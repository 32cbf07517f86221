#include "robot.h"

namespace wax {

namespace {

// After a pause of the program the speeds continue from where they were, without a jump.
const uint8_t MAX_STEP_MS = 20;

// Older than any frame that is not late; capped so that it never wraps.
const uint32_t LONG_AGO_MS = 60000;

uint16_t ttl_of(const Frame &frame) {
    return frame.ttl_ms < MAX_TTL_MS ? frame.ttl_ms : MAX_TTL_MS;
}

int16_t within(int16_t value, int16_t limit) {
    if (value > limit) return limit;
    if (value < -limit) return -limit;
    return value;
}

}  // namespace

Robot::Robot(const Settings &settings, uint32_t now_ms)
    : settings_(settings),
      parts_{Ramp(settings.acceleration_mmps2, settings.braking_mmps2),
             Ramp(settings.acceleration_mmps2, settings.braking_mmps2),
             Ramp(settings.acceleration_mmps2, settings.braking_mmps2)},
      hello_ms_(now_ms),
      servos_{Servo(settings.servos[0]), Servo(settings.servos[1]), Servo(settings.servos[2]),
              Servo(settings.servos[3])},
      ticked_ms_(now_ms),
      turned_ms_(now_ms),
      reported_ms_(now_ms) {}

Verdict Robot::next(uint32_t now_ms, Frame &frame) {
    if (!decoder_.next(session_, frame)) return Verdict::NOTHING;
    const Verdict verdict = judge(frame, now_ms);
    if (verdict == Verdict::TAKEN)
        obey(frame, now_ms);
    else
        ++refused_;
    return verdict;
}

Verdict Robot::judge(const Frame &frame, uint32_t now_ms) const {
    if (frame.type == HELLO || frame.type == STOP) return Verdict::TAKEN;
    if (frame.type == MOVE && !settings_.base.moves_sideways()) return Verdict::CANNOT;
    if (timed_out_ || has_run_out(now_ms)) return Verdict::TIMED_OUT;
    if (frame.turn < turn_) return Verdict::OLD_TURN;
    if (!is_newer(frame.sequence)) return Verdict::OLD_SEQUENCE;
    if (is_late(frame, now_ms)) return Verdict::LATE;
    return Verdict::TAKEN;
}

bool Robot::is_newer(uint16_t sequence) const {
    return static_cast<uint16_t>(sequence - sequence_ - 1) < 0x7FFF;
}

bool Robot::is_late(const Frame &frame, uint32_t now_ms) const {
    const uint32_t ahead_ms = frame.time_ms - now_ms;
    if (ahead_ms <= MAX_AHEAD_MS) return false;
    const uint32_t age_ms = now_ms - frame.time_ms;
    return age_ms > ttl_of(frame) || age_ms > now_ms - hello_ms_;
}

bool Robot::has_run_out(uint32_t now_ms) const {
    return driven_ && now_ms - arrived_ms_ >= ttl_ms_;
}

void Robot::obey(const Frame &frame, uint32_t now_ms) {
    switch (frame.type) {
        case HELLO:
            session_ = frame.session;
            turn_ = 0;
            sequence_ = frame.sequence;
            hello_ms_ = now_ms;
            report_now_ = true;
            stand();
            return;
        case DRIVE:
        case MOVE:
            go(frame);
            arrived_ms_ = now_ms;
            ttl_ms_ = ttl_of(frame);
            driven_ = true;
            break;
        case AXIS:
            if (frame.axis >= AXES) break;
            axes_[frame.axis] = within(frame.position, FULL_POSITION);
            told_axes_ = static_cast<uint8_t>(told_axes_ | 1 << frame.axis);
            break;
        default:
            stand();
    }
    if (frame.turn > turn_) turn_ = frame.turn;
    if (is_newer(frame.sequence)) sequence_ = frame.sequence;
}

// A bumper that is pressed on the side of the motion ends it. Turning on the spot is allowed.
void Robot::go(const Frame &frame) {
    const Base &base = settings_.base;
    read(base, frame, wanted_);
    const int32_t ahead = static_cast<int32_t>(frame.left_mmps) + frame.right_mmps + frame.linear_mmps;
    blocking_ = 0;
    if (ahead > 0) blocking_ = settings_.front_bumpers;
    if (ahead < 0) blocking_ = settings_.back_bumpers;
    if (frame.lateral_mmps > 0) blocking_ = static_cast<uint8_t>(blocking_ | base.left_bumpers);
    if (frame.lateral_mmps < 0) blocking_ = static_cast<uint8_t>(blocking_ | base.right_bumpers);
}

void Robot::stand() {
    driven_ = false;
    for (int32_t &wanted : wanted_) wanted = 0;
    timed_out_ = false;
}

void Robot::tick(uint32_t now_ms, const Inputs &inputs) {
    if (has_run_out(now_ms)) {
        stand();
        timed_out_ = true;
        report_now_ = true;
    }
    if (now_ms - hello_ms_ > LONG_AGO_MS) hello_ms_ = now_ms - LONG_AGO_MS;

    const uint32_t elapsed_ms = now_ms - ticked_ms_;
    ticked_ms_ = now_ms;
    const uint8_t step_ms =
        elapsed_ms < MAX_STEP_MS ? static_cast<uint8_t>(elapsed_ms) : MAX_STEP_MS;
    watch_wheels(now_ms, inputs);
    static const int32_t STANDSTILL[PARTS] = {};
    ramp(inputs_.bumpers & blocking_ ? STANDSTILL : wanted_, step_ms);
    bool moves = turning_;
    for (const Ramp &part : parts_)
        if (part.speed() != 0) moves = true;

    for (uint8_t at = 0; at < AXES; ++at)
        if (told_axes_ & 1 << at) servos_[at].approach(axes_[at], step_ms);

    if (moves != moving_) {
        moving_ = moves;
        report_now_ = true;
    }
}

// Each side has its limits; of a base that moves sideways the robot has them, in any direction, and
// its wheels follow it. So no wheel turns the robot because it stops before another.
void Robot::ramp(const int32_t *targets, uint8_t step_ms) {
    if (settings_.base.moves_sideways()) {
        Ramp::approach_as_one(parts_[0], parts_[1], targets, step_ms);
    } else {
        parts_[0].approach(targets[0], step_ms);
        parts_[1].approach(targets[1], step_ms);
    }
    parts_[2].approach(targets[2], step_ms);
    const int32_t now[PARTS] = {parts_[0].speed(), parts_[1].speed(), parts_[2].speed()};
    mix(settings_.base, now, mmps_);
}

void Robot::watch_wheels(uint32_t now_ms, const Inputs &inputs) {
    if (inputs.left_ticks != inputs_.left_ticks || inputs.right_ticks != inputs_.right_ticks) {
        turning_ = true;
        turned_ms_ = now_ms;
    } else if (now_ms - turned_ms_ >= settings_.still_ms) {
        turning_ = false;
    }
    inputs_ = inputs;
}

bool Robot::report(uint32_t now_ms, uint8_t *bytes) {
    if (!report_now_ && now_ms - reported_ms_ < REPORT_EVERY_MS) return false;
    report_now_ = false;
    reported_ms_ = now_ms;
    Report report;
    report.own_sequence = ++own_sequence_;
    report.turn = turn_;
    report.time_ms = now_ms;
    report.battery_mv = inputs_.battery_mv;
    report.bumpers = inputs_.bumpers;
    report.left_ticks = inputs_.left_ticks;
    report.right_ticks = inputs_.right_ticks;
    report.moving = moving_;
    report.timed_out = timed_out_;
    report.moves_sideways = settings_.base.moves_sideways();
    report.sequence = sequence_;
    report.damaged = damaged();
    report.refused = refused_;
    write_report(report, session_, bytes);
    return true;
}

}  // namespace wax
