#include "ramp.h"

namespace wax {

namespace {

int32_t least(int32_t a, int32_t b) { return a < b ? a : b; }
int32_t most(int32_t a, int32_t b) { return a > b ? a : b; }

// The length of a vector, exact to a 16000th.
uint32_t length_of(int32_t x, int32_t y) {
    uint32_t a = static_cast<uint32_t>(most(x, -x)), b = static_cast<uint32_t>(most(y, -y));
    uint8_t halved = 0;
    for (; (a | b) >= 0x8000; ++halved) {
        a /= 2;
        b /= 2;
    }
    uint32_t square = a * a + b * b, root = 0;
    for (uint32_t bit = UINT32_C(1) << 30; bit != 0; bit /= 4) {
        const uint32_t tried = root + bit;
        root /= 2;
        if (square < tried) continue;
        square -= tried;
        root += bit;
    }
    return root << halved;
}

// That part of a way which is covered in some of the time that is left, to the nearest: a part that
// is rounded down could stay on its way for ever.
int32_t share(int32_t way, uint8_t elapsed_ms, int32_t left_ms) {
    if (left_ms <= elapsed_ms) return way;
    return (way * elapsed_ms + (way < 0 ? -left_ms : left_ms) / 2) / left_ms;
}

}  // namespace

void Ramp::approach(int32_t target, uint8_t elapsed_ms) {
    const int32_t faster = static_cast<int32_t>(acceleration_) * elapsed_ms;
    const int32_t slower = static_cast<int32_t>(braking_) * elapsed_ms;
    if (speed_ > 0) {
        speed_ = target >= speed_ ? least(speed_ + faster, target)
                                  : most(speed_ - slower, most(target, 0));
    } else if (speed_ < 0) {
        speed_ = target <= speed_ ? most(speed_ - faster, target)
                                  : least(speed_ + slower, least(target, 0));
    } else {
        speed_ = target >= 0 ? least(faster, target) : most(-faster, target);
    }
}

// How much of its speed a target takes away, to standstill at most.
int32_t Ramp::slowing(int32_t target) const {
    if (speed_ > 0) return least(most(target, 0) - speed_, 0);
    return most(least(target, 0) - speed_, 0);
}

void Ramp::approach_as_one(Ramp &ahead, Ramp &aside, const int32_t *targets, uint8_t elapsed_ms) {
    const uint8_t rest_ms = add(ahead, aside, ahead.slowing(targets[0]), aside.slowing(targets[1]),
                                ahead.braking_, elapsed_ms);
    if (rest_ms != 0)
        add(ahead, aside, targets[0] - ahead.speed_, targets[1] - aside.speed_,
            ahead.acceleration_, rest_ms);
}

// Go as far as this rate allows, and return the time that is left over, with the last millisecond
// if it is not needed whole.
uint8_t Ramp::add(Ramp &ahead, Ramp &aside, int32_t x, int32_t y, uint16_t rate,
                  uint8_t elapsed_ms) {
    const uint32_t length = length_of(x, y);
    const int32_t left_ms = static_cast<int32_t>((length + rate - 1) / rate);
    ahead.speed_ += share(x, elapsed_ms, left_ms);
    aside.speed_ += share(y, elapsed_ms, left_ms);
    return left_ms <= elapsed_ms ? static_cast<uint8_t>(elapsed_ms - length / rate) : 0;
}

}  // namespace wax
